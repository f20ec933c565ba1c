#include "tumble/formats/file/text_lines.hpp"

#include <cmath>

#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/lines.hpp"
#include "tumble/formats/csv/number.hpp"
#include "tumble/units/error.hpp"

namespace tumble::file {

void each_line(const std::string& path, const std::string& encoding, const Progress& progress,
               const std::function<void(std::string_view line, std::size_t number)>& take) {
  csv::Lines lines(path, encoding);
  std::size_t number = 0;
  for (std::string_view piece = lines.next(); !piece.empty(); piece = lines.next()) {
    report(progress, static_cast<double>(lines.done()) / static_cast<double>(lines.size() + 1), "reading");
    while (!piece.empty()) {
      const auto end = piece.find('\n');
      std::string_view line = piece.substr(0, end);
      piece.remove_prefix(end == std::string_view::npos ? piece.size() : end + 1);
      while (line.ends_with('\r')) line.remove_suffix(1);
      take(line, ++number);
    }
  }
}

bool number_of(std::string_view cell, char mark, double& value) {
  cell = csv::trimmed(cell);
  if (cell.starts_with('+')) cell.remove_prefix(1);
  const fast_float::parse_options options{fast_float::chars_format::general, mark};
  const auto result = fast_float::from_chars_advanced(cell.data(), cell.data() + cell.size(), value, options);
  return !cell.empty() && result.ec == std::errc() && result.ptr == cell.data() + cell.size() && std::isfinite(value);
}

void Problems::add(std::size_t line, const Sentence& problem) {
  if (++count_ <= 10) first_.push_back({Where{.file = path_, .line = line, .place = say("line {}", line)}, problem});
}

void Problems::refuse_any() const {
  if (count_ == 0) return;
  const Sentence many =
      count_ == 1 ? say("{} place that cannot be read", count_) : say("{} places that cannot be read", count_);
  tumble::Problems problems{{Where{.file = path_, .place = say("'{}'", Name{path_})}, many}};
  problems.insert(problems.end(), first_.begin(), first_.end());
  if (count_ > first_.size()) problems.push_back(say("and {} more", count_ - first_.size()));
  throw Error{Error::Kind::bad_file, problems};
}

}  // namespace tumble::file
