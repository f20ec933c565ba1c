#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/math/random.hpp"

/// How reality departs from a plan: each way as a function on a simulated test (decision 117).
namespace tumble {

/// A test whose answer is known: as it was planned, as it was carried out, and what was recorded.
struct SimulatedTest {
  Evidence evidence;  ///< the plan as planned, and the recordings of what was carried out
  Plan carried_out;   ///< equal to the planned one until a departure changes it
  std::vector<std::pair<std::string, double>> truth;  ///< parameter name, true value [SI]
  std::uint64_t seed = 0;                             ///< of the simulation
  /// As the simulator made it from the plan that was carried out; null: the recordings were not made from a plan, and
  /// only departures of recordings can happen to the test.
  std::shared_ptr<const Recording> simulated = nullptr;
};

/// One departure that happens.
struct Happening {
  std::string target;  ///< one of Departure::targets
  double size = 0.0;   ///< [SI of Departure::unit]
  RandomStream random{0};
};

using Recordings = std::vector<Recording>;

/// An entry of the catalogue of departures. It changes the plan that is carried out, or what was recorded, or both.
struct Departure {
  const char* name;
  const char* summary;
  /// Each thing that it can happen to: an axis of the rig, a channel, or "" for the whole test. Empty: not to this test.
  std::vector<std::string> (*targets)(const Plan& plan, const Recordings& recordings);
  /// Codes of the findings that name it rightly; empty: the result must hold in spite of it.
  std::vector<std::string> told_by;
  const char* unit = "";  ///< of its size; empty: that of the channel
  /// [SI of the unit] size that the budget of the test covers: as the plan states it, else a constant with its reason. Null:
  /// it has no size, and there is one cell.
  double (*covered)(const Plan& plan, const Recordings& recordings, const std::string& target) = nullptr;
  void (*carry_out)(Plan& carried_out, const Happening& what) = nullptr;  ///< before the simulation; null: as planned
  /// After the simulation; null: the recordings stay as they are.
  void (*record)(const Plan& planned, Recordings& recordings, const Happening& what) = nullptr;
  bool drifts = false;  ///< what carry_out changes grows evenly from nothing to its size over the test
};

/// All entries, subject by subject.
const std::vector<Departure>& departure_catalogue();

/// The entry of that name, or Error::unsupported with the nearest known name.
const Departure& find_departure(std::string_view name);

/// The sizes of a departure [SI of its unit] for a test: 0.3, 1 and 10 times what the budget covers; {0} where it has
/// no size.
std::vector<double> sizes_of(const Departure& departure, const SimulatedTest& test, const std::string& target);

/// Each thing that the departure can happen to in this test; empty: to nothing in it. A departure of the plan needs recordings
/// that were made from a plan.
std::vector<std::string> targets_of(const Departure& departure, const SimulatedTest& test);

/// The plan carried out as it is planned. The truth is that of the terms of the first instrument.
/// Throws Error::bad_input as `simulate` does.
SimulatedTest simulated_test(const Plan& plan, std::uint64_t seed);

/// A test that was made elsewhere, with its truth [SI]. Where its recording is the one that `simulate(plan, seed)` gives, perhaps with
/// something added to the samples of a channel, departures of the plan can happen to it too.
SimulatedTest simulated_test(Evidence evidence, std::vector<std::pair<std::string, double>> truth, std::uint64_t seed);

/// The test with the departure.
///
/// Given     target  one of `targets_of`
///           size    [SI of the unit of the departure]
/// Throws    Error::bad_input where the rig cannot carry out what the departure asks of it, or where the test has samples
///           that do not follow from its plan
SimulatedTest with_departure(const SimulatedTest& test, const Departure& departure, const std::string& target,
                             double size, std::uint64_t seed);

}  // namespace tumble
