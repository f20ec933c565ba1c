#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/regression/mixed_model.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/rigs/rig.hpp"

/// Effects of the named errors of the rigs on the observations of a method: the shift is the difference between the rig
/// with an error at one standard deviation and the rig without errors.
namespace tumble {

/// One error of the rig of one plan. Errors of different plans are different numbers, also where their names agree.
struct PlanError {
  std::size_t plan = 0;   ///< PowerUp::plan_number
  std::size_t index = 0;  ///< row of RigRun::errors
  std::size_t count = 0;  ///< of all errors of that rig
  RigError error;
};

/// Standard deviation of one error of a plan's rig [SI].
///
/// Given     name   one of rigs/error_names.hpp
/// Returned  nothing where the plan has no rig, or a rig that has no such error
std::optional<double> rig_sd(const Plan& plan, std::string_view name);

/// The errors of the rigs with a standard deviation above zero, plan by plan. Rigs that several power-ups share are
/// listed once.
std::vector<PlanError> rig_errors(const std::vector<PowerUp>& power_ups);

/// Unique among the plans: "gravity", "gravity of plan 2".
std::string name_of(const PlanError& error);

/// The key of errors of gravity [m/s^2], as stated or as it follows from latitude and height.
std::string gravity_key(double gravity);
/// The key of errors of the latitude [rad].
std::string latitude_key(double latitude);

/// Key of an error: another test with this key has the error that was drawn once here. It is the equipment that the
/// plan names, or gravity or the latitude as stated; empty: no other test. How the instrument was mounted is an error
/// of this test alone.
std::string key_of(const ConductedTest& test, const PlanError& error);

/// Whether the error is present in a segment of a power-up.
using InSegment = std::function<bool(std::size_t segment)>;

/// One standard deviation of the error in the segments chosen [SI], as RigRun::errors has it: errors x segments.
Matrix error_values(const PowerUp& power_up, const PlanError& error, const InSegment& chosen);

/// Motion of the rig with the error at one standard deviation in the segments chosen.
Reference reference_with(const PowerUp& power_up, const PlanError& error, const InSegment& chosen);

/// One number drawn: an error of the whole test, or of one segment in one start.
struct ErrorDraw {
  PlanError error;
  struct Segment {
    std::size_t power_up = 0, segment = 0, start = 0;
  };
  std::optional<Segment> only = {};  ///< absent: drawn once, in all segments of all power-ups of its plan
};

/// Every number that the rigs' errors draw in a test; those of each segment once for every start of its power-up.
///
/// Given     channels   the test as each channel shows it, at least one; they have the same power-ups
std::vector<ErrorDraw> draws_of(const std::vector<const ConductedTest*>& channels);

/// The observation in each stretch with an error at one standard deviation in all segments.
template <class Value>
struct WithError {
  PlanError error;
  std::vector<Value> observed;  ///< one a stretch; as without errors in those of other plans
};

/// Asks the rigs with each of their errors, in parallel.
///
/// Given     stretches   pointers to what is observed: Stretch, or a method's own with a member power_up
///           nominal     what is observed in each without errors
///           observe     called with (Reference, Stretch), returns Value; from several threads
template <class Value, class AnyStretch, class Observe>
std::vector<WithError<Value>> observed_with_errors(const std::vector<PowerUp>& power_ups,
                                                   const std::vector<const AnyStretch*>& stretches,
                                                   const std::vector<Value>& nominal, const Observe& observe) {
  std::vector<WithError<Value>> all;
  for (auto& error : rig_errors(power_ups)) all.push_back({std::move(error), nominal});
  parallel_for(all.size(), [&](std::size_t k) {
    std::map<std::size_t, Reference> references;
    for (std::size_t i = 0; i < stretches.size(); ++i) {
      const std::size_t u = stretches[i]->power_up;
      if (power_ups[u].plan_number != all[k].error.plan) continue;
      if (!references.contains(u))
        references[u] = reference_with(power_ups[u], all[k].error, [](std::size_t) { return true; });
      all[k].observed[i] = observe(references[u], *stretches[i]);
    }
  });
  return all;
}

/// How closely a method looks at what is felt: as its result needs it, or just enough to see which segment moves it.
enum class Detail { full, coarse };

/// Rows of one stretch, of one output each.
using OutputRows = std::span<const std::span<double>>;

/// The rows that a method observes, of one output, or of several with rows at the same samples: the rig is asked once
/// for all of them.
struct Observation {
  std::vector<std::size_t> stretch;  ///< of each row, ascending; index in ConductedTest::stretches
  std::size_t outputs = 1;
  /// Adds what the rows of one stretch show to `rows` [SI]: one element each. Called from several threads.
  std::function<void(const Reference& reference, std::size_t stretch, Detail detail, OutputRows rows)> add;
  /// Whether a stretch is the total of a move from one angle to the next, so that the draws of two segments move it;
  /// null: none is.
  std::function<bool(std::size_t stretch)> is_total = nullptr;
};

/// The shift of every row by one standard deviation of each error of the rigs, one-sided.
///
/// An error drawn anew for each segment moves the stretches of that segment, and of those after it for which the axis
/// stays where it is: stretches that one draw moves share a column, the others have draws of their own in one element
/// with each_segment. Shifts below 1e-13 of the greatest row are rounding and are dropped.
///
/// Returned  of each output: named effects, column [SI], with the names of the numbers drawn
std::vector<std::vector<KnownEffect>> rig_effects(const ConductedTest& test, const Observation& observation);

}  // namespace tumble
