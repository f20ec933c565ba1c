#include "tumble/tasks/validation/bench.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/math/normal.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble::validation {
namespace {

/// Samples of the kept tests may take this much [bytes] together: each of them has its recording twice.
constexpr std::size_t most_kept = std::size_t{1} << 30;

std::size_t bytes_of(const SimulatedTest& test) {
  std::size_t samples = 0;
  for (const Recording& recording : test.evidence.recordings)
    for (const Channel& channel : recording.channels) samples += channel.values.size();
  return 2 * samples * sizeof(double);
}

bool has_truth(const Bench& bench, const std::string& name) {
  return std::ranges::any_of(bench.truth, [&](const auto& one) { return one.first == name; });
}

void add_truth(Bench& bench, const std::string& name, double value) {
  if (std::isfinite(value) && !has_truth(bench, name)) bench.truth.emplace_back(name, value);
}

/// Whether [truth] has another value under this name: the instrument and the method then mean different things by it.
bool is_ambiguous(const Bench& bench, const std::string& name, double value) {
  constexpr double alike =
      0.01;  // [1] g of a site and the standard g differ by less, another sign or definition by more
  if (!bench.plan.truth.has(name)) return false;
  const double stated = bench.plan.truth.number(name);
  return std::abs(stated - value) > alike * std::abs(stated);
}

/// The true values: of terms by the instrument's table, of what a method computes from them by its prediction, of others as
/// [truth] says them, by their name or with that of the channel before it. None that two of them contradict each other about.
void add_truths(const std::vector<std::pair<std::string, double>>& terms, const Evidence& evidence, Bench& bench) {
  std::vector<std::pair<std::string, double>> known;
  if (bench.predicted)
    for (const Parameter& parameter : bench.predicted->parameters) known.emplace_back(parameter.name, parameter.value);
  known.insert(known.end(), terms.begin(), terms.end());
  std::set<std::string> ambiguous;
  for (const auto& [name, value] : known)
    if (is_ambiguous(bench, name, value)) ambiguous.insert(name);
  for (const auto& [name, value] : known)
    if (!ambiguous.contains(name)) add_truth(bench, name, value);
  std::vector<std::string> before{""};
  for (const auto& role : find_method(bench.plan.method).roles())
    if (const Channel* channel = channel_for(evidence, evidence.recordings.front(), role.name)) {
      before.push_back(channel->name + "_");
      if (channel->kind == QuantityKind::angular_rate) before.emplace_back("gyro_");
      if (channel->kind == QuantityKind::specific_force) before.emplace_back("accelerometer_");
    }
  const Settings& stated = bench.plan.truth;
  for (const Parameter& parameter : bench.parameters)
    for (const std::string& prefix : before)
      if (const std::string name = prefix + parameter.name; stated.has(name) && !ambiguous.contains(parameter.name))
        add_truth(bench, parameter.name, stated.number(name));
}

void predict_for(Bench& bench) try { bench.predicted = predict(bench.plan); } catch (const Error& error) {
  bench.not_predicted = sentence_of(error.problems.front());
}

/// Keeps the parameters of a result with a value and an uncertainty.
void take_parameters(const Estimate& estimate, Bench& bench) {
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const auto [lower, upper] = interval95(estimate, i);
    if (std::isfinite(estimate.parameters[i].value) && upper > lower)
      bench.parameters.push_back(estimate.parameters[i]);
  }
}

void take_values(const Estimate& estimate, const Bench& bench, Outcome& outcome) {
  for (std::size_t j = 0; j < bench.parameters.size(); ++j) {
    const Parameter* found = find_parameter(estimate, bench.parameters[j].name);
    if (found == nullptr || !std::isfinite(found->value)) continue;
    const auto [lower, upper] = interval95(estimate, static_cast<std::size_t>(found - estimate.parameters.data()));
    outcome.values[j] = found->value;
    outcome.sds[j] = 0.5 * (upper - lower) / normal_two_sided_95;
  }
}

}  // namespace

std::shared_ptr<const SimulatedTest> sound_test(const Bench& bench, std::size_t trial) {
  if (trial < bench.kept.size() && bench.kept[trial]) return bench.kept[trial];
  auto test = simulated_test(bench.plan, bench.seed + trial);
  test.truth = bench.truth;
  return std::make_shared<const SimulatedTest>(std::move(test));
}

Outcome outcome_of(const Bench& bench, const SimulatedTest& test) {
  Outcome outcome;
  outcome.values.assign(bench.parameters.size(), std::nan(""));
  outcome.sds = outcome.values;
  try {
    const Estimate estimate = identify(test.evidence, {});
    outcome.answer = answer_of(estimate, test.truth);
    take_values(estimate, bench, outcome);
  } catch (const Error& error) {
    outcome.answer = {.refusal = error.what(), .refusal_code = code_of_refusal(error, test)};
  }
  return outcome;
}

Bench bench_of(const Plan& plan, std::uint64_t seed) {
  if (plan.method.empty())
    throw Error(Error::Kind::bad_input, in_file(plan.file, say("a validation needs a plan with a method")));
  Bench bench{.plan = plan, .seed = seed};
  SimulatedTest first = simulated_test(plan, seed);
  predict_for(bench);
  const Estimate estimate = [&] {
    try {
      return identify(first.evidence, {});
    } catch (const Error& error) {
      throw Error(Error::Kind::bad_data,
                  within(say("the test as it is planned has no result"), error.problems.front()));
    }
  }();
  take_parameters(estimate, bench);
  add_truths(first.truth, first.evidence, bench);
  first.truth = bench.truth;
  if (seeds * bytes_of(first) <= most_kept)
    bench.kept.assign(seeds, nullptr), bench.kept[0] = std::make_shared<const SimulatedTest>(std::move(first));
  return bench;
}

void carry_out_sound_tests(Bench& bench, std::size_t trials, const std::function<void()>& done) {
  bench.sound.resize(trials);
  parallel_for(bench.sound.size(), [&](std::size_t i) {
    const auto test = sound_test(bench, i);
    bench.sound[i] = outcome_of(bench, *test);
    if (i < bench.kept.size()) bench.kept[i] = test;
    done();
  });
}

}  // namespace tumble::validation
