#include "tumble/departures/departure.hpp"

#include <algorithm>
#include <iterator>

#include "tumble/core/find.hpp"
#include "tumble/departures/entries/entries.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {
namespace {

std::vector<Departure> all_departures() {
  using namespace entries;
  std::vector<Departure> all;
  for (auto* subject : {of_clocks, of_stamps, of_positions, of_motions, of_rigs, of_encoders, of_marks, of_channels,
                        of_electronics, of_converters, of_samples, of_drifts, of_surroundings})
    std::ranges::move(subject(), std::back_inserter(all));
  return all;
}

}  // namespace

const std::vector<Departure>& departure_catalogue() {
  static const std::vector<Departure> all = all_departures();
  return all;
}

const Departure& find_departure(std::string_view name) {
  std::vector<std::string> known;
  for (const Departure& departure : departure_catalogue()) {
    if (departure.name == name) return departure;
    known.emplace_back(departure.name);
  }
  throw Error(Error::Kind::unsupported,
              say("there is no departure '{}'{}", Name{std::string(name)}, did_you_mean(std::string(name), known)));
}

std::vector<double> sizes_of(const Departure& departure, const SimulatedTest& test, const std::string& target) {
  if (departure.covered == nullptr) return {0.0};
  const double covered = departure.covered(test.evidence.plan, test.evidence.recordings, target);
  return {0.3 * covered, covered, 10.0 * covered};
}

std::vector<std::string> targets_of(const Departure& departure, const SimulatedTest& test) {
  if (departure.carry_out != nullptr && test.simulated == nullptr) return {};
  return departure.targets(test.evidence.plan, test.evidence.recordings);
}

}  // namespace tumble
