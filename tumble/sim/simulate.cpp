#include "tumble/sim/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/math/parallel.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using sim::PowerUp;
using sim::Source;

void append_noise_problems(const Plan& plan, const std::string& prefix, std::vector<std::string>& problems) {
  for (const char* name : {"quantization_noise", "angle_random_walk", "bias_instability", "rate_random_walk",
                           "markov_sd", "turn_on_repeatability"})
    if (plan.truth.number(prefix + name) < 0.0)
      problems.push_back(fmt::format("[truth] {}{} must not be negative", prefix, name));
  if (plan.truth.number(prefix + "markov_sd") > 0.0 && !(plan.truth.number(prefix + "markov_time") > 0.0))
    problems.push_back(fmt::format("[truth] {0}markov_time must be positive where {0}markov_sd is given", prefix));
}

void refuse_incomplete(const Plan& plan) {
  std::vector<std::string> problems;
  if (plan.instrument_model.empty()) problems.push_back("to simulate, the plan needs [instrument] model = \"...\"");
  if (plan.rig_kind.empty()) problems.push_back("to simulate, the plan needs [rig] kind = \"...\"");
  if (!(plan.sample_rate > 0.0))
    problems.push_back("to simulate, the plan needs [instrument] rate = \"1 Hz\" or the like");
  if (plan.schedule.empty()) problems.push_back("to simulate, the plan needs at least one [[schedule]]");
  if (problems.empty() && plan.truth.texts().empty()) problems.push_back("to simulate, the plan needs [truth]");
  if (problems.empty()) {
    std::string last = "none yet";  // outputs of one kind stand together and share their noise
    for (const auto& output : find_model(plan.instrument_model).outputs(plan.truth))
      if (output.noise_prefix != last) append_noise_problems(plan, last = output.noise_prefix, problems);
    if (plan.truth.integer("oversampling") < 1) problems.push_back("[truth] oversampling must be 1 or more");
  }
  if (!problems.empty()) {
    for (auto& problem : problems) problem = plan.file.empty() ? problem : plan.file + ": " + problem;
    throw Error(Error::Kind::bad_input, problems);
  }
}

/// All that a power-up records, the instrument's outputs first.
std::vector<Source> sources_of(const Plan& plan, const PowerUp& run, const RandomStream& random) {
  const Reference reference = sim::reference_of(plan, run, random);
  auto sources = sim::outputs_of(plan, reference, run, random);
  for (auto& sensor : sim::sensors_of(plan, reference, run)) sources.push_back(std::move(sensor));
  return sources;
}

/// What the recording says of itself; no channels.
Recording frame_of(const Plan& plan, std::uint64_t seed) {
  Recording recording;
  recording.instrument = plan.instrument_model + (plan.instrument_serial.empty() ? "" : " " + plan.instrument_serial);
  double now = 0.0;
  for (const auto& segment : plan.schedule) {
    recording.marks.push_back({segment.label, now, segment.run});
    now += segment.duration;
  }
  recording.meta = {{"title", plan.title}, {"simulated", "yes"}, {"seed", std::to_string(seed)}};
  return recording;
}

std::size_t samples_of(const std::vector<PowerUp>& runs) {
  std::size_t samples = 0;
  for (const auto& run : runs) samples += run.samples;
  return samples;
}

}  // namespace

Recording simulate(const Plan& plan, std::uint64_t seed, const Progress& progress) {
  refuse_incomplete(plan);
  const auto runs = sim::power_ups(plan.schedule, plan.sample_rate);
  const RandomStream random(seed);
  report(progress, 0.0, "simulating");

  // One job a power-up and channel.
  std::vector<std::vector<Source>> sources(runs.size());
  parallel_for(runs.size(), [&](std::size_t r) { sources[r] = sources_of(plan, runs[r], random); });
  Recording recording = frame_of(plan, seed);
  for (const auto& source : sources.front()) {
    recording.channels.push_back(source.channel);
    recording.channels.back().values.resize(samples_of(runs));
  }
  const std::size_t channels = recording.channels.size();
  std::vector<std::size_t> first(runs.size(), 0);
  for (std::size_t r = 1; r < runs.size(); ++r) first[r] = first[r - 1] + runs[r - 1].samples;
  parallel_for(runs.size() * channels, [&](std::size_t job) {
    const std::size_t r = job / channels, c = job % channels;
    sources[r][c].next(std::span(recording.channels[c].values).subspan(first[r], runs[r].samples));
  });
  report(progress, 1.0, "simulating");
  return recording;
}

void simulate(const Plan& plan, std::uint64_t seed, std::size_t samples,
              const std::function<void(const Recording& block)>& sink, const Progress& progress) {
  refuse_incomplete(plan);
  const auto runs = sim::power_ups(plan.schedule, plan.sample_rate);
  const RandomStream random(seed);
  const auto all = static_cast<double>(samples_of(runs));
  std::size_t done = 0;
  for (const auto& run : runs) {
    auto sources = sources_of(plan, run, random);
    for (std::size_t first = 0; first < run.samples; first += samples) {
      report(progress, static_cast<double>(done) / all, "simulating");
      Recording block = frame_of(plan, seed);
      const std::size_t size = std::min(samples, run.samples - first);
      for (const auto& source : sources) {
        block.channels.push_back(source.channel);
        block.channels.back().timeline.start = runs.front().begin + static_cast<double>(done) / plan.sample_rate;
        block.channels.back().values.resize(size);
      }
      parallel_for(sources.size(), [&](std::size_t c) { sources[c].next(block.channels[c].values); });
      sink(block);
      done += size;
    }
  }
  report(progress, 1.0, "simulating");
}

std::size_t simulated_size(const Plan& plan) {
  refuse_incomplete(plan);
  const auto runs = sim::power_ups(plan.schedule, plan.sample_rate);
  const Rig& rig = find_rig(plan.rig_kind);
  PowerUp probe = runs.front();  // the first segment is enough to see which sensors there are
  probe.segments.resize(1);
  probe.segments.front().duration = 1.0 / plan.sample_rate;
  const auto sensors =
      rig.reference({probe.segments, plan.rig, plan.site, plan.sample_rate, {}, RandomStream(0)}).sensors;
  const auto outputs = find_model(plan.instrument_model).outputs(plan.truth);
  return samples_of(runs) * (sensors.size() + outputs.size()) * sizeof(double);
}

}  // namespace tumble
