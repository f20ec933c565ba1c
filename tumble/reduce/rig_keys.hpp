#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tumble/core/estimate.hpp"

/// Which errors of rigs results have in common where their keys do not say it: the plan of one names no equipment, or
/// two write it in different ways. Taken as common they make a mean less certain and a prior weaker, never the reverse;
/// where results are compared with each other, such errors are not common (exchange/comparison).
namespace tumble::rig_keys {

/// Key of an error of a rig of which no result says which one it is.
inline constexpr const char* unstated = "rig that no result names";

/// Whether a line of a budget is an error that a rig has once for all tests: one that has the key of its equipment where
/// the plan states it.
bool is_error_of_rig(const std::string& source);

/// The letters and digits of a key, small: "H-1, cert. 7" and "h-1 cert 7" are one.
std::string plain(const std::string& key);

/// Whether two keys differ by one character that is missing in one, or is not a digit in both: digits number things.
bool look_like_a_slip(const std::string& a, const std::string& b);

/// Keys that a set of results uses, by source of the error.
class Keys {
 public:
  /// The keys that most of the results have, in the spelling that most of them use.
  explicit Keys(const std::vector<const Estimate*>& results);

  /// The key that a line has among these results: its own in their spelling; for an error of a rig without one that
  /// which most results have for it; else empty.
  std::string of(const Contribution& line) const;

 private:
  std::map<std::pair<std::string, std::string>, std::string> spelling_;  ///< by source and plain key
  std::map<std::string, std::string> most_;                              ///< by source
};

/// The result with the keys that these results, the population among them, have for the same errors. A rig that the
/// result names is that of a population which names none.
Estimate with_keys_of(Estimate result, const Estimate& population);

/// The lines of rigs whose key is not stated are there: a finding `rig_not_stated`; keys that differ by one character:
/// `equipment_alike`. Nothing: neither.
Findings about_keys(const std::vector<const Estimate*>& results);

}  // namespace tumble::rig_keys
