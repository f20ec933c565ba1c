#include "tumble/sim/simulate.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/math/parallel.hpp"
#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// The segments of one power-up.
struct PowerUp {
  int run;
  double begin;  ///< [s]
  Schedule segments;
};

std::vector<PowerUp> power_ups(const Schedule& schedule) {
  std::vector<PowerUp> out;
  double now = 0.0;
  for (const auto& segment : schedule) {
    if (out.empty() || out.back().run != segment.run) out.push_back({segment.run, now, {}});
    out.back().segments.push_back(segment);
    now += segment.duration;
  }
  return out;
}

void refuse_incomplete(const Plan& plan) {
  std::vector<std::string> problems;
  if (plan.instrument_model.empty()) problems.push_back("to simulate, the plan needs [instrument] model = \"...\"");
  if (plan.rig_kind.empty()) problems.push_back("to simulate, the plan needs [rig] kind = \"...\"");
  if (!(plan.sample_rate > 0.0))
    problems.push_back("to simulate, the plan needs [instrument] rate = \"1 Hz\" or the like");
  if (plan.schedule.empty()) problems.push_back("to simulate, the plan needs at least one [[schedule]]");
  if (problems.empty() && plan.truth.texts().empty()) problems.push_back("to simulate, the plan needs [truth]");
  if (problems.empty())
    for (const char* name : {"quantization_noise", "angle_random_walk", "bias_instability", "rate_random_walk",
                             "markov_sd", "turn_on_repeatability"})
      if (plan.truth.number(name) < 0.0) problems.push_back(fmt::format("[truth] {} must not be negative", name));
  if (problems.empty() && plan.truth.number("markov_sd") > 0.0 && !(plan.truth.number("markov_time") > 0.0))
    problems.push_back("[truth] markov_time must be positive where markov_sd is given");
  if (!problems.empty()) {
    for (auto& problem : problems) problem = plan.file.empty() ? problem : plan.file + ": " + problem;
    throw Error(Error::Kind::bad_input, problems);
  }
}

/// Output of the instrument in one power-up: terms, turn-on bias, noise.
std::vector<double> output_of(const std::vector<Felt>& felt, const std::vector<Term>& terms, const Plan& plan,
                              const RandomStream& random) {
  std::vector<double> output(felt.size(),
                             plan.truth.number("turn_on_repeatability") * random.split("turn-on").normal(0));
  for (const auto& term : terms) {
    const double coefficient = plan.truth.number(term.name);
    if (coefficient == 0.0) continue;
    for (std::size_t k = 0; k < felt.size(); ++k) output[k] += coefficient * term.regressor(felt[k]);
  }
  add_noise(noise_of(plan.truth), plan.sample_rate, random.split("noise"), output);
  return output;
}

/// Channels of the parts joined end to end.
std::vector<Channel> joined(std::vector<std::vector<Channel>> parts) {
  std::vector<Channel> whole = std::move(parts.front());
  for (std::size_t p = 1; p < parts.size(); ++p)
    for (std::size_t c = 0; c < whole.size(); ++c)
      whole[c].values.insert(whole[c].values.end(), parts[p][c].values.begin(), parts[p][c].values.end());
  return whole;
}

}  // namespace

Recording simulate(const Plan& plan, std::uint64_t seed, const Progress& progress) {
  refuse_incomplete(plan);
  const Model& model = find_model(plan.instrument_model);
  const Rig& rig = find_rig(plan.rig_kind);
  const auto terms = model.terms(plan.truth);
  const auto runs = power_ups(plan.schedule);
  const RandomStream random(seed);
  report(progress, 0.0, "simulating");

  std::vector<std::vector<Channel>> parts(runs.size());
  parallel_for(runs.size(), [&](std::size_t r) {
    const auto stream = random.split("run").split(static_cast<std::uint64_t>(runs[r].run));
    auto felt =
        rig.reference(runs[r].segments, runs[r].begin, plan.rig, plan.site, plan.sample_rate, stream.split("rig"));
    Channel output{
        "gyro", model.output, Unit::parse(model.output_unit), {runs[r].begin, plan.sample_rate, nullptr}, {}};
    if (model.output == QuantityKind::specific_force) output.name = "accelerometer";
    output.values = output_of(felt.felt, terms, plan, stream.split("instrument"));
    parts[r].push_back(std::move(output));
    for (auto& sensor : felt.sensors) parts[r].push_back(std::move(sensor));
  });

  Recording recording;
  recording.instrument = plan.instrument_model + (plan.instrument_serial.empty() ? "" : " " + plan.instrument_serial);
  recording.channels = joined(std::move(parts));
  double now = 0.0;
  for (const auto& segment : plan.schedule) {
    recording.marks.push_back({segment.label, now, segment.run});
    now += segment.duration;
  }
  recording.meta = {{"title", plan.title}, {"simulated", "yes"}, {"seed", std::to_string(seed)}};
  report(progress, 1.0, "simulating");
  return recording;
}

}  // namespace tumble
