#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tumble/tasks/validation/sizes.hpp"

namespace tumble::validation {

/// Results of tests with a departure of one size, beside the sound tests of the same seeds.
struct Tried {
  double size = 0.0;     ///< [SI]
  bool possible = true;  ///< false: no such test can be made, for the reason `why_not`
  std::optional<Sentence> why_not = {};
  bool named = false;              ///< named in nine of ten tests, or without a result there
  bool refused = false;            ///< most of them have no result
  double shift = 0.0;              ///< [sd] of the parameter that moves most
  std::string parameter;           ///< that moves most
  std::vector<std::string> codes;  ///< that name it; where none does, others of most tests that sound ones lack
};

/// Makes and reduces tests with one departure, each of them once.
class Trying {
 public:
  Trying(const Bench& bench, const Cell& cell) : bench_(bench), cell_(cell) {}

  /// Only the shift, by as few seeds as show it. Given: size [SI].
  Tried shifted(double size) { return tried(size, false); }
  /// Whether it is named too, by ten seeds or as many as decide it. Given: size [SI].
  Tried whole(double size) { return tried(size, true); }

  const SimulatedTest& sound(std::size_t trial);
  std::size_t tests() const { return tests_; }

 private:
  Tried tried(double size, bool ask_all);
  const Outcome& outcome(double size, std::size_t trial);

  const Bench& bench_;
  const Cell cell_;
  std::shared_ptr<const SimulatedTest> sound_;
  std::size_t sound_trial_ = 0, tests_ = 0;
  std::map<std::pair<double, std::size_t>, Outcome> outcomes_;
};

}  // namespace tumble::validation
