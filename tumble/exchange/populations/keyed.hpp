#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/reduce/rig_keys.hpp"

namespace tumble::populations {

/// Source and key of a line of a budget.
using Key = std::pair<std::string, std::string>;

/// The errors that several results share: their columns, one a draw. Errors of rigs that results do not name count as
/// those of one rig (reduce/rig_keys.hpp).
class SharedErrors {
 public:
  /// Keys that two results or more have, with one number of draws in all of them.
  explicit SharedErrors(const std::vector<const Estimate*>& results);

  std::size_t draws() const { return draws_; }
  bool holds(const Contribution& line) const { return first_.contains({line.source, as_.of(line)}); }
  /// The signed factors of these rows of a result [rows x draws].
  Matrix columns_of(const Estimate& result, const std::vector<std::size_t>& rows) const;
  /// Covariance of these rows by all other lines [rows x rows]; where the lines that are shared give a parameter all of
  /// its variance, a part in 1e8 of it remains.
  Matrix private_of(const Estimate& result, const std::vector<std::size_t>& rows) const;
  /// First column and number of columns of each key.
  const std::map<Key, std::pair<std::size_t, std::size_t>>& keys() const { return first_; }

 private:
  rig_keys::Keys as_;
  std::map<Key, std::pair<std::size_t, std::size_t>> first_;
  std::size_t draws_ = 0;
};

/// Table of the results that were not used.
Table left_out_table(const std::vector<std::pair<std::string, Sentence>>& unit_and_why);

}  // namespace tumble::populations
