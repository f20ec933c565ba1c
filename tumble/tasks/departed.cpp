#include "tumble/tasks/departed.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

constexpr const char* meta_key = "departures";

/// What it happens to in the test: what was asked for, or the only thing.
std::string target_in(const WantedDeparture& wanted, const SimulatedTest& test) {
  const auto targets = targets_of(*wanted.departure, test);
  if (std::ranges::find(targets, wanted.target) != targets.end()) return wanted.target;
  if (wanted.target.empty() && targets.size() == 1) return targets.front();
  refuse_target(*wanted.departure, targets, wanted.target);
}

/// As people write it.
std::string text_of(const WantedDeparture& wanted) {
  std::string text = wanted.departure->name;
  if (!wanted.target.empty()) text += ":" + wanted.target;
  return wanted.size ? fmt::format("{}={} {}", text, wanted.size->value, wanted.size->unit.text()) : text;
}

std::string text_of(const std::vector<WantedDeparture>& departures) {
  std::vector<std::string> said;
  for (const WantedDeparture& wanted : departures) said.push_back(text_of(wanted));
  return joined(said, "; ");
}

void refuse_size(const WantedDeparture& wanted) {
  const Departure& departure = *wanted.departure;
  if (wanted.size && departure.covered == nullptr)
    throw Error(Error::Kind::bad_input, say("'{}' has no size: it happens or it does not", Name{departure.name}));
  if (!wanted.size && departure.covered != nullptr)
    throw Error(Error::Kind::bad_input, say("'{0}' needs a size: {0}=SIZE", Name{departure.name}));
}

}  // namespace

WantedDeparture wanted_departure(const std::string& text) {
  const auto with_size = key_and_value(text);
  const std::string what = with_size ? with_size->first : text;
  const auto with_target = key_and_value(what, ':');
  WantedDeparture wanted{.departure = &find_departure(with_target ? with_target->first : what),
                         .target = with_target ? with_target->second : ""};
  if (with_size) wanted.size = parse_quantity(with_size->second);
  refuse_size(wanted);
  return wanted;
}

std::vector<WantedDeparture> wanted_departures(const std::vector<std::string>& texts) {
  std::vector<WantedDeparture> wanted;
  Problems problems;
  for (const std::string& text : texts) try {
      wanted.push_back(wanted_departure(text));
    } catch (const Error& error) {
      for (const Problem& problem : error.problems)
        problems.push_back(within(say("--departure {}", Name{text}), problem));
    }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return wanted;
}

Unit unit_of_size(const Departure& departure, const Recordings& recordings, const std::string& target) {
  if (*departure.unit != 0) return Unit::parse(departure.unit);
  for (const Recording& recording : recordings)
    if (const Channel* channel = find_channel(recording, target)) return channel->unit;
  return {};
}

double size_in(const Quantity& size, const Unit& unit) {
  if (size.unit.dimension() != unit.dimension() || (size.bare && unit.text() != "1"))
    throw Error(Error::Kind::bad_input,
                say("a size in {} [{}] is expected", Name{unit.text()}, Name{name(unit.dimension())}));
  return size.unit.difference_to_si(size.value);
}

void refuse_target(const Departure& departure, const std::vector<std::string>& targets, const std::string& target) {
  if (targets.empty())
    throw Error(Error::Kind::bad_input, say("'{}' cannot happen to this test", Name{departure.name}));
  if (target.empty())
    throw Error(Error::Kind::bad_input, say("'{0}' can happen to several things, say to which: {0}:TARGET, of {1}",
                                            Name{departure.name}, fmt::join(targets, ", ")));
  throw Error(Error::Kind::bad_input,
              say("'{}' cannot happen to '{}'{}", Name{departure.name}, Name{target}, did_you_mean(target, targets)));
}

SimulatedTest departed_test(const Plan& plan, const std::vector<WantedDeparture>& departures, std::uint64_t seed) {
  SimulatedTest test = simulated_test(plan, seed);
  for (const WantedDeparture& wanted : departures) {
    const std::string target = target_in(wanted, test);
    const Unit unit = unit_of_size(*wanted.departure, test.evidence.recordings, target);
    test = with_departure(test, *wanted.departure, target, wanted.size ? size_in(*wanted.size, unit) : 0.0, seed);
  }
  return test;
}

Recordings simulate_departed(const Plan& plan, const std::vector<WantedDeparture>& departures, std::uint64_t seed) {
  Recordings recordings = std::move(departed_test(plan, departures, seed).evidence.recordings);
  for (Recording& recording : recordings) recording.meta[meta_key] = text_of(departures);
  return recordings;
}

DepartedPlan departed_plan(const Plan& plan, const std::vector<WantedDeparture>& departures, std::uint64_t seed) {
  DepartedPlan departed{.planned = plan, .carried_out = plan, .said = text_of(departures)};
  const SimulatedTest test = simulated_test(plan, seed);  // which channels there are
  for (const WantedDeparture& wanted : departures) {
    const Departure& departure = *wanted.departure;
    if (departure.drifts)
      throw Error(Error::Kind::bad_input,
                  say("'{}' grows during the test, which a rehearsal cannot do: simulate it", Name{departure.name}));
    const std::string target = target_in(wanted, test);
    const Unit unit = unit_of_size(departure, test.evidence.recordings, target);
    const Happening what{target, wanted.size ? size_in(*wanted.size, unit) : 0.0,
                         RandomStream(seed).split("departure").split(departure.name)};
    if (departure.carry_out != nullptr) departure.carry_out(departed.carried_out, what);
    if (departure.record != nullptr) departed.recorded.emplace_back(&departure, what);
  }
  return departed;
}

void depart(const DepartedPlan& plan, Recordings& recordings) {
  for (const auto& [departure, what] : plan.recorded) {
    const auto targets = departure->targets(plan.planned, recordings);
    if (std::ranges::find(targets, what.target) == targets.end()) refuse_target(*departure, targets, what.target);
    departure->record(plan.planned, recordings, what);
  }
  for (Recording& recording : recordings) recording.meta[meta_key] = plan.said;
}

}  // namespace tumble
