#include "tumble/formats/csv/rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "tumble/formats/csv/number.hpp"
#include "tumble/units/error.hpp"

namespace tumble::csv {

namespace {

constexpr double missing_sample = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t shown_problems = 10;

/// Of ten, of the last digit of a number that parse_number() left to slower code.
int last_place(const std::string& number) {
  const auto e = number.find_first_of("eE");
  const auto point = number.find('.');
  const auto digits = std::min(e, number.size());
  const int power = e == std::string::npos ? 0 : std::atoi(number.c_str() + e + 1);
  return point < digits ? power - static_cast<int>(digits - point - 1) : power;
}

template <bool blanks>
bool separates(char c, char separator) {
  return blanks ? c == ' ' || c == '\t' : c == separator;
}

}  // namespace

Rows::Rows(std::string path, const Layout& layout, std::string_view missing, Look look)
    : path_(std::move(path)),
      layout_(layout),
      missing_(lower_case(missing)),
      time_(layout.columns.size()),
      label_(layout.columns.size()),
      stamped_(layout.stamp.stamped()),
      looked_at_(look == Look::at_all ? layout.columns.size() : 0),
      line_(layout.lines) {
  for (std::size_t i = 0; i < layout.columns.size(); ++i) {
    slot_.push_back(layout.columns[i].wanted ? static_cast<int>(slots_++) : -1);
    if (layout.columns[i].time) time_ = i;
    if (layout.columns[i].label) label_ = i;
    if (layout.columns[i].wanted || layout.columns[i].label || stamp_column(i))
      looked_at_ = std::max(looked_at_, i + 1);
  }
}

/// The end of a cell that is not wanted as a number; its label or stamp is taken. Null where any_row() must look.
template <bool blanks>
const char* Rows::plain_text_cell(const char* p, std::size_t column, std::size_t row) {
  const char separator = layout_.separator;
  const char* after = p;
  while (!separates<blanks>(*after, separator) && *after != '\n' && *after != '\r' && *after != '"') ++after;
  const std::string_view cell(p, static_cast<std::size_t>(after - p));
  if (column == label_ && *after != '"') take_label(cell, row);
  return stamp_column(column) && !take_stamp(cell, column, row) ? nullptr : after;
}

/// One line of plain cells; null where something is out of the ordinary, and any_row() must look.
template <bool blanks>
const char* Rows::plain_row(const char* p, const char* end, std::size_t row) {
  const std::size_t count = targets_.size();
  const char separator = layout_.separator;
  const auto skip = [](const char* at) {
    while (*at == ' ' || (blanks && *at == '\t')) ++at;
    return at;
  };
  for (std::size_t column = 0; column < count; ++column) {
    p = skip(p);
    double value = 0.0;
    int exponent = 0;
    const char* after = p;
    if (targets_[column] == nullptr) {
      after = plain_text_cell<blanks>(p, column, row);
      if (after == nullptr) return nullptr;
    } else {
      after = parse_number(p, layout_.mark, value, exponent);
      if (column == time_) {
        if (after == nullptr) return nullptr;
        exponent_ = std::min(exponent_, exponent);
      } else if (after == nullptr) {
        if (blanks || count == 1) return nullptr;
        value = missing_sample;
        after = p;
      }
      targets_[column][row] = value;
    }
    p = after;
    if (column + 1 == count) break;
    if (column + 1 == looked_at_)
      return static_cast<const char*>(std::memchr(p, '\n', static_cast<std::size_t>(end - p))) + 1;
    if (!separates<blanks>(*p, separator) && !blanks) p = skip(p);
    if (!separates<blanks>(*p, separator)) return nullptr;
    ++p;
  }
  if (*p == ' ' || *p == '\t') p = skip(p);
  while (*p == '\r') ++p;
  return *p == '\n' ? p + 1 : nullptr;
}

/// Whether a line without a number is a sample: without a clock a blank line of the only column, or one of tabs alone.
bool Rows::is_row_of_blanks(std::string_view line) const {
  if (time_ < targets_.size() || stamped_ || label_ < targets_.size()) return false;
  if (targets_.size() == 1) return targets_.front() != nullptr;
  return layout_.separator == '\t' && line.find('\t') != std::string_view::npos;
}

const char* Rows::any_row(const char* p, const char* end, std::size_t& row) {
  const auto* const stop = static_cast<const char*>(std::memchr(p, '\n', static_cast<std::size_t>(end - p)));
  const std::string_view written(p, static_cast<std::size_t>(stop - p));
  const auto line = trimmed(written);
  const bool comment = line.starts_with('#');
  if (!comment && !line.empty() && blank_lines_ > 0) {
    --blank_lines_;
    for (double* const target : targets_)
      if (target != nullptr) target[row] = missing_sample;
    ++row;
    return p;
  }
  ++line_;
  if (line.empty() && is_row_of_blanks(written)) ++blank_lines_;
  if (!comment && !line.empty()) take_cells(cells_of(written, layout_.separator), row++);
  return stop + 1;
}

void Rows::take_cells(const std::vector<std::string>& cells, std::size_t row) {
  const std::size_t count = targets_.size();
  std::size_t given = cells.size();
  while (given > count && cells[given - 1].empty()) --given;  // separators at the end of the line
  if (given != count) {
    note(count, given == 1 ? say("{} cell instead of {}", given, count) : say("{} cells instead of {}", given, count));
    return;
  }
  for (std::size_t column = 0; column < count; ++column)
    if (targets_[column] != nullptr) targets_[column][row] = value_of(cells[column], column);
  if (label_ < count) take_label(cells[label_], row);
  for (std::size_t column = 0; column < count; ++column)
    if (stamp_column(column) && !take_stamp(cells[column], column, row))
      note(column, cells[column].empty()
                       ? Sentence("a row without its time")
                       : say("'{}' is not a time written as in the first rows", plain_text(cells[column], 40)));
}

/// False where the cell holds no stamp of the format of its column.
bool Rows::take_stamp(std::string_view cell, std::size_t column, std::size_t row) {
  const auto& parts = layout_.stamp.columns;
  std::size_t part = 0;
  while (parts[part].index != column) ++part;
  Stamp stamp;
  if (!parse_stamp(trimmed(cell), parts[part].format, stamp)) return false;
  stamp_target_[part * Batch::capacity + row] = stamp.time;
  if (part + 1 == parts.size()) exponent_ = std::min(exponent_, stamp.place);
  return true;
}

void Rows::take_label(std::string_view label, std::size_t row) {
  label = trimmed(label);
  if (labelled_ && label == last_label_) return;
  labelled_ = true;
  last_label_ = label;
  labels_.push_back({row, last_label_});
}

double Rows::value_of(std::string cell, std::size_t column) {
  if (cell.empty() || (!missing_.empty() && lower_case(cell) == missing_)) {
    if (column == time_) note(column, "a row without its time");
    return missing_sample;
  }
  const std::string written = cell;
  if (grouped_.empty() && in_groups(cell, layout_.mark == '.' ? ',' : '.', layout_.mark)) grouped_ = cell;
  if (layout_.mark != '.') {
    if (cell.find('.') != std::string::npos) {
      note(column, say("'{}' has a point, but the decimal mark here is a comma", plain_text(written, 40)));
      return missing_sample;
    }
    std::replace(cell.begin(), cell.end(), layout_.mark, '.');
  }
  const char* const first = cell.data() + (cell.starts_with('+') && !cell.starts_with("+-"));
  const char* const last = cell.data() + cell.size();
  double value = missing_sample;
  const auto result = fast_float::from_chars(first, last, value);
  if (result.ec == std::errc() && result.ptr == last && std::isfinite(value)) {
    if (column == time_) exponent_ = std::min(exponent_, last_place(cell));
    return value;
  }
  if (layout_.mark == '.' && std::ranges::count(cell, ',') == 1 && cell.find('.') == cell.npos && numeric(cell))
    commas_ = true;
  const bool number = result.ptr == last && (std::isinf(value) || result.ec == std::errc::result_out_of_range);
  if (word_.empty() && reads_like_missing(cell)) word_ = cell;
  const std::string cell_text = plain_text(written, 40);
  note(column, number ? say("'{}' is not finite", cell_text) : say("'{}' is not a number", cell_text));
  return missing_sample;
}

void Rows::note(std::size_t column, Sentence what) {
  if (++bad_ > shown_problems) return;
  Where where{.file = path_, .line = line_, .place = say("line {}", line_)};
  if (column < layout_.columns.size()) {
    where.column = column + 1, where.channel = layout_.columns[column].name;
    where.place = say("line {}, column {} '{}'", line_, column + 1, Name{where.channel});
  }
  notes_.emplace_back(std::move(where), std::move(what));
}

void Rows::finish() const {
  if (bad_ == 0) return;
  const Sentence many =
      bad_ == 1 ? say("{} place that cannot be read", bad_) : say("{} places that cannot be read", bad_);
  Problems problems{{Where{.file = path_, .place = say("'{}'", Name{path_})}, many}};
  problems.insert(problems.end(), notes_.begin(), notes_.end());
  if (bad_ > notes_.size()) problems.push_back(say("and {} more", bad_ - notes_.size()));
  problems.push_back(say(
      "accepted are decimal numbers; leave the cell blank for a missing sample, or pass --set missing={} if that word "
      "means one",
      Name{word_.empty() ? "NaN" : plain_text(word_, 40)}));
  if (!grouped_.empty()) {
    std::string plain = grouped_;
    std::erase(plain, layout_.mark == '.' ? ',' : '.');
    problems.push_back(say("numbers with a mark between thousands are not read: export '{}' in place of '{}'",
                           plain_text(plain, 40), plain_text(grouped_, 40)));
  }
  if (commas_)
    problems.push_back(layout_.separator == ','
                           ? "commas stand in numbers and between columns: export the file with semicolons or tabs"
                           : "if the comma is the decimal mark, pass --set decimal=comma");
  throw Error{Error::Kind::bad_file, problems};
}

void Rows::parse(std::string_view& text, Batch& batch) {
  batch.cells.resize(slots_ * Batch::capacity);
  targets_.clear();
  for (const int slot : slot_) targets_.push_back(slot < 0 ? nullptr : batch.cells.data() + slot * Batch::capacity);
  if (stamped_) {
    batch.stamps.resize(layout_.stamp.columns.size() * Batch::capacity);
    stamp_target_ = batch.stamps.data();
  }
  exponent_ = batch.rows == 0 ? std::numeric_limits<int>::max() : batch.time_exponent;
  const char* p = text.data();
  const char* const end = p + text.size();
  const bool blanks = layout_.separator == ' ';
  std::size_t row = batch.rows;
  while (p < end && row < Batch::capacity) {
    const char* after = nullptr;
    if (blank_lines_ == 0) after = blanks ? plain_row<true>(p, end, row) : plain_row<false>(p, end, row);
    if (after != nullptr) {
      ++line_;
      ++row;
    } else {
      after = any_row(p, end, row);
    }
    p = after;
  }
  batch.rows = row;
  std::move(labels_.begin(), labels_.end(), std::back_inserter(batch.labels));
  labels_.clear();
  batch.time_exponent = exponent_;
  text.remove_prefix(static_cast<std::size_t>(p - text.data()));
}

}  // namespace tumble::csv
