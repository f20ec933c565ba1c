#include <algorithm>
#include <cmath>
#include <optional>

#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/clock.hpp"
#include "tumble/formats/csv/number.hpp"

namespace tumble::csv {

namespace {

/// The number in a cell, with either decimal mark.
std::optional<double> number_in(std::string cell) {
  std::ranges::replace(cell, ',', '.');
  double value = 0.0;
  const auto result = fast_float::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (result.ec != std::errc() || result.ptr != cell.data() + cell.size()) return std::nullopt;
  return value;
}

double median_of(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The contents of the cells of one column.
ColumnSample sample_of(const std::vector<std::vector<std::string>>& rows, std::size_t c) {
  ColumnSample sample;
  std::size_t words = 0, filled = 0, stamps = 0;
  bool first = true;
  std::vector<double> steps;
  for (const auto& row : rows) {
    if (c >= row.size() || row[c].empty()) continue;
    const std::string& cell = row[c];
    sample.empty = false;
    if (in_groups(cell, ',', '.') && cell.find(',') == cell.rfind(',') && cell.find('.') == cell.npos) {
      if (sample.grouped.empty()) sample.grouped = cell;
    } else {
      sample.decimal_commas = sample.decimal_commas || cell.find(',') != cell.npos;
    }
    ++filled;
    const StampKind kind = stamp_kind(cell);
    if (kind != StampKind::none && (stamps == 0 || kind == sample.kind)) {
      sample.kind = kind;
      ++stamps;
      sample.cells.push_back(cell);
    } else if (const auto value = number_in(cell); value && std::isfinite(*value)) {
      sample.numbers = true;
      if (first)
        sample.first = *value;
      else if (*value != sample.last)
        steps.push_back(std::abs(*value - sample.last));
      first = false;
      sample.last = *value;
      sample.greatest = std::max(sample.greatest, std::abs(*value));
    } else {
      words += !numeric(cell);
      if (sample.other.empty()) sample.other = cell;
    }
  }
  sample.step = median_of(steps);
  if (2 * stamps <= filled) sample.kind = StampKind::none;
  sample.text = sample.kind == StampKind::none && 2 * words > filled;
  return sample;
}

}  // namespace

std::vector<ColumnSample> sampled(const std::vector<std::vector<std::string>>& rows, std::size_t columns) {
  std::vector<ColumnSample> samples;
  for (std::size_t c = 0; c < columns; ++c) samples.push_back(sample_of(rows, c));
  return samples;
}

}  // namespace tumble::csv
