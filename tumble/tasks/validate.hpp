#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/departures/judgement.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/unit.hpp"

/// Shows from a plan alone whether its test holds, and what could go wrong in it without anybody noticing (decision 127).
namespace tumble {

/// Settings of a validation.
struct ValidateOptions {
  std::size_t trials = 100;           ///< sound tests, ten or more
  std::uint64_t seed = 1;             ///< of the first test; the others have the numbers after it
  std::string departure;              ///< only this one; empty: all that the plan's channels allow
  std::string target;                 ///< only there: an axis or a channel; empty: everything that it can happen to
  std::optional<Quantity> size = {};  ///< only this one, a difference; absent: it is searched
  /// Called after the first test with the number of tests [1] that the rest takes about, of as many processors as there are.
  std::function<void(std::size_t tests)> begun = {};
};

/// How the interval of a parameter held in sound tests. Values [SI].
struct ValidatedParameter {
  std::string name, symbol;
  Unit unit;
  std::size_t tests = 0;        ///< that give a value
  std::optional<double> truth;  ///< absent: the plan does not say it, and neither coverage nor bias is known
  std::size_t held = 0;         ///< tests whose 95 % interval holds the truth
  double coverage_lower = 0.0;  ///< [1] ends of the 95 % interval of the coverage
  double coverage_upper = 1.0;
  std::optional<double> predicted;  ///< standard uncertainty before the test; absent: nothing predicts it
  double stated = 0.0;              ///< standard uncertainty of a result, rms of the tests
  double scatter = 0.0;             ///< standard deviation of the values
  double bias = 0.0;                ///< mean of the values minus the truth

  double coverage() const { return static_cast<double>(held) / static_cast<double>(tests); }  ///< [1]
};

/// Whether a departure would be noticed before it makes a result wrong.
enum class Exposure {
  unnoticed,      ///< it moves a parameter by its sd and is not named, at any size tried or at some
  named_in_time,  ///< it is named, or there is no result, before it moves a parameter by its sd
  harmless        ///< no parameter moves by its sd
};
std::string_view name(Exposure exposure);

/// One departure that happens to one target of the test. Sizes [SI] are differences; NaN: there is no such size.
struct DepartureStudy {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  const Departure* departure = nullptr;
  std::string target;              ///< an axis, a channel; empty: the whole test
  Unit unit;                       ///< that people are shown sizes in
  bool sized = true;               ///< false: it happens or it does not
  double covered = none;           ///< what the budget of the test covers
  double moves = none;             ///< the size that moves a parameter by its sd
  double named = none;             ///< the size that is named in nine of ten tests, or at which they have no result
  double greatest = none;          ///< the greatest size tried that is not named
  std::string parameter;           ///< that moves most at `greatest`, else at `moves`
  double shift = 0.0;              ///< [sd of the parameter] that it moves there
  std::vector<std::string> codes;  ///< of findings that name it, or where none does of those that are said instead
  bool refused = false;            ///< the tests that name it have no result
  Exposure exposure = Exposure::harmless;
};

/// A departure that could not be made, and why.
struct NotTried {
  const Departure* departure = nullptr;
  std::string target;
  Sentence why;
};

/// All that simulated tests show of a plan.
struct Validation {
  Plan plan;
  std::size_t trials = 0;
  std::uint64_t seed = 1;
  std::size_t tests = 0;  ///< simulated and reduced in all
  std::vector<ValidatedParameter> parameters;
  std::optional<Sentence> not_predicted;   ///< why nothing predicts the uncertainties
  Accusations sound;                       ///< what is said of tests that are carried out as planned
  std::vector<DepartureStudy> departures;  ///< the worst first
  std::vector<NotTried> not_tried;
};

/// Simulates the test of a plan as planned, and with each departure, and compares what its method says with the truth.
///
/// Throws    Error::bad_input for a plan without a method, with all that it lacks to be simulated, for less than ten trials, for
///           a target that the departure cannot happen to, and for a size of a departure that has none or one of another dimension;
///           Error::unsupported for a departure that is not known;
///           Error::bad_data where no sound test has a result
Validation validate(const Plan& plan, const ValidateOptions& options, const Progress& progress);

/// The validation as an estimate without parameters, which every front end shows: tables `coverage`, `unnoticed`,
/// `what_would_show_it`, `other_departures`, `not_tried`, and findings.
Estimate report_of(const Validation& validation);

}  // namespace tumble
