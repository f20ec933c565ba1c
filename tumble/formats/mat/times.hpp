#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tumble/formats/mat/array.hpp"

namespace tumble::mat {

/// "imu" of "imu.gyro"; empty for a variable of its own.
std::string parent_of(const std::string& name);

/// The unit of time that the name of a variable implies; nothing where it is no time.
std::optional<std::string> time_unit(const std::string& name);

/// The times and sampling rates of a file, by the structure in which they stand: found once, and not again for every array.
class Times {
 public:
  explicit Times(const std::vector<Array>& arrays);

  bool is_time(std::size_t array) const;
  /// The first time in the structure `at` of as many samples as the array, and not the array itself.
  std::optional<std::size_t> time_in(const std::string& at, std::size_t array) const;
  /// [Hz] of the structure `at`.
  std::optional<double> rate_in(const std::string& at) const;

 private:
  const std::vector<Array>& arrays_;
  std::map<std::pair<std::string, std::size_t>, std::vector<std::size_t>>
      times_;                            ///< the first two, by place and length
  std::map<std::string, double> rates_;  ///< [Hz]
};

}  // namespace tumble::mat
