#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/formats/file/even_clock.hpp"
#include "tumble/formats/file/series.hpp"
#include "tumble/formats/uff58/binary.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::uff58 {

/// Characters `first` to `first + count` of a record of fixed width, without blanks around.
std::string_view field(std::string_view line, std::size_t first, std::size_t count);

/// Numbers of Fortran [as written]: in columns that may touch ("1.0E+00-2.0E+00"), with D for E.
/// Returned: false at the first text that is not a number.
bool numbers_in(std::string_view line, std::vector<double>& numbers);

long whole_number(std::string_view text, long otherwise);

/// One dataset 58 as it is read.
struct Dataset {
  std::size_t line = 0;  ///< of its first record
  std::vector<std::string> records;
  std::size_t numbers = 0;                         ///< that were read
  std::shared_ptr<file::Series> abscissa, values;  ///< [as written]; none of the abscissa where it is even
  file::EvenClock clock = {};                      ///< of the abscissa
  Unit time = Unit::parse("s");
  std::string time_problem;                ///< empty: its unit is one of time
  long kind = 0, ordinate = 0, count = 0;  ///< function type; 2, 4: real; 5, 6: complex
  bool even = true;
  double start = 0.0, step = 0.0;  ///< of the abscissa, in its unit
  std::optional<BinaryHead> binary = {};
  BinaryNumbers binary_numbers = {};

  bool real() const { return ordinate == 2 || ordinate == 4; }
  std::size_t needed() const { return static_cast<std::size_t>(count) * (even ? 1 : 2); }
};

constexpr std::size_t head_records = 11;

}  // namespace tumble::uff58
