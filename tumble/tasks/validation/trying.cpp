#include "tumble/tasks/validation/trying.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/tasks/validation/shifts.hpp"
#include "tumble/units/error.hpp"

namespace tumble::validation {
namespace {

constexpr auto least = static_cast<std::size_t>(least_named * static_cast<double>(seeds) + 0.5);

/// The verdict of one test beside the sound one.
CellVerdict verdict_of(const Outcome& outcome, const Outcome& sound, const Departure& departure) {
  return judge_cell({&outcome.answer, 1}, {&sound.answer, 1}, departure.told_by, false);
}

/// Counts in how many tests each code is said that the sound test of the same seed lacks.
void count_codes(const Outcome& outcome, const Outcome& sound, std::map<std::string, std::size_t>& counts) {
  std::vector<std::string> codes = outcome.answer.codes;
  if (!outcome.answer.refusal_code.empty()) codes.push_back(outcome.answer.refusal_code);
  std::ranges::sort(codes);
  codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
  for (const std::string& code : codes)
    if (std::ranges::find(sound.answer.codes, code) == sound.answer.codes.end()) ++counts[code];
}

/// Codes of more than half of the tests; those that name the departure alone where there are some.
std::vector<std::string> said_mostly(const std::map<std::string, std::size_t>& counts, std::size_t tests,
                                     const std::vector<std::string>& told_by) {
  std::vector<std::string> naming, others;
  for (const auto& [code, count] : counts)
    if (2 * count > tests) (std::ranges::find(told_by, code) != told_by.end() ? naming : others).push_back(code);
  return naming.empty() ? others : naming;
}

}  // namespace

const SimulatedTest& Trying::sound(std::size_t trial) {
  if (!sound_ || sound_trial_ != trial) sound_ = sound_test(bench_, trial), sound_trial_ = trial;
  return *sound_;
}

const Outcome& Trying::outcome(double size, std::size_t trial) {
  const auto [at, fresh] = outcomes_.try_emplace({size, trial});
  if (!fresh) return at->second;
  try {
    const SimulatedTest departed =
        with_departure(sound(trial), *cell_.departure, cell_.target, size, bench_.seed + trial);
    at->second = outcome_of(bench_, departed);
  } catch (...) {
    outcomes_.erase(at);
    throw;
  }
  ++tests_;
  return at->second;
}

Tried Trying::tried(double size, bool ask_all) {
  Tried tried{.size = size};
  std::size_t named = 0, refused = 0, tests = 0;
  std::map<std::string, std::size_t> counts;
  Shifts shifts(bench_);
  const auto decided = [&] { return !ask_all || named >= least || tests - named > seeds - least; };
  for (; tests < seeds && !(decided() && (refused > 0 || shifts.settled())); ++tests) try {
      const Outcome &one = outcome(size, tests), &sound = bench_.sound[tests];
      const CellVerdict verdict = verdict_of(one, sound, *cell_.departure);
      named += verdict.named + verdict.refused > 0 ? 1 : 0;
      refused += verdict.refused;
      shifts.add(one, sound);
      count_codes(one, sound, counts);
    } catch (const Error& error) {
      if (error.kind == Error::Kind::internal) throw;
      return {.size = size, .possible = false, .why_not = sentence_of(error.problems.front())};
    }
  tried.named = named >= least;
  tried.refused = 2 * refused > tests;
  const Shift worst = shifts.worst();
  tried.shift = worst.size;
  if (worst.size > 0.0) tried.parameter = bench_.parameters[worst.parameter].name;
  tried.codes = said_mostly(counts, tests, cell_.departure->told_by);
  return tried;
}

}  // namespace tumble::validation
