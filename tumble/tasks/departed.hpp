#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tumble/departures/departure.hpp"
#include "tumble/units/unit.hpp"

/// Simulated tests with departures that somebody asks for.
namespace tumble {

/// A departure as somebody asks for it.
struct WantedDeparture {
  const Departure* departure = nullptr;
  std::string target;                 ///< empty: the only thing that it can happen to
  std::optional<Quantity> size = {};  ///< a difference; absent: it has none
};

/// From what people write: "clock_fast=300 ppm", "positions_offset:head=20 arcsec", "order_changed".
/// Throws Error::unsupported for an unknown name; Error::bad_input for a size that cannot be read, is missing, or that the
/// departure does not have
WantedDeparture wanted_departure(const std::string& text);

/// Each of them.
std::vector<WantedDeparture> wanted_departures(const std::vector<std::string>& texts);

/// The unit in which people are shown sizes of a departure: its own, else that of the channel that it happens to.
Unit unit_of_size(const Departure& departure, const Recordings& recordings, const std::string& target);

/// A size [SI] as somebody gives it, a difference. Throws Error::bad_input where its dimension is not that of `unit`.
double size_in(const Quantity& size, const Unit& unit);

/// Throws Error::bad_input: the departure cannot happen to `target`, only to `targets`.
[[noreturn]] void refuse_target(const Departure& departure, const std::vector<std::string>& targets,
                                const std::string& target);

/// The test of a plan, with the departures one after the other.
/// Throws Error::bad_input as simulate(), with_departure() and the functions above
SimulatedTest departed_test(const Plan& plan, const std::vector<WantedDeparture>& departures, std::uint64_t seed);

/// The recordings of this test, which say in their meta data what departs from the plan.
Recordings simulate_departed(const Plan& plan, const std::vector<WantedDeparture>& departures, std::uint64_t seed);

/// A plan that somebody carries out with departures, a rehearsal.
struct DepartedPlan {
  Plan planned, carried_out;
  /// To the recordings, when it has been carried out.
  std::vector<std::pair<const Departure*, Happening>> recorded = {};
  std::string said = {};  ///< the departures, as people write them
};
/// Throws    as departed_test(), and Error::bad_input for a departure that grows during the test
DepartedPlan departed_plan(const Plan& plan, const std::vector<WantedDeparture>& departures, std::uint64_t seed);

/// Changes the recordings of this plan as the departures do. Throws Error::bad_input where these lack what it happens to.
void depart(const DepartedPlan& plan, Recordings& recordings);

}  // namespace tumble
