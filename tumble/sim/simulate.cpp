#include "tumble/sim/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/core/attempt.hpp"
#include "tumble/core/unit_facts.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double most_samples = 1e12;  ///< a channel: 8 TB

/// What the instrument's model finds wrong with its terms, physics and electronics.
void append_truth_problems(const Plan& plan, const Participant& participant, Problems& problems) {
  const auto& [prefix, model, truth, mount] = participant;
  const std::size_t before = problems.size();
  const auto outputs = attempt(problems, [&] { return model.outputs(truth); });
  if (model.coefficients) attempt(problems, [&] { return model.coefficients(truth); });
  const double step = 1.0 / (plan.sample_rate * oversampling_of(plan));
  for (std::size_t k = 0; model.record && k < outputs.size(); ++k)
    attempt(problems, [&] { return model.record(truth, k, step, RandomStream(0)); });
  if (model.record && outputs.empty())  // even so: what it says does not depend on the terms
    attempt(problems, [&] { return model.record(truth, 0, step, RandomStream(0)); });
  if (!prefix.empty())
    for (std::size_t k = before; k < problems.size(); ++k)
      if (const Sentence* said = about_truth(problems[k]))
        problems[k] = say("[beside.{}truth] {}", Name{prefix}, *said);
}

/// All instruments make their steps together.
void append_oversampling_problems(const Plan& plan, Problems& problems) {
  const int oversampling = oversampling_of(plan);
  for (const auto& one : plan.beside)
    if (const int own = one.truth.integer("oversampling"); own != 0 && own != oversampling)
      problems.push_back(
          say("[beside.{}.truth] oversampling = {}, but all instruments make their steps "
              "together: write it in [truth], where it is {}",
              Name{one.name}, own, oversampling));
}

/// The fastest that a motion is [Hz]; 0: it does not oscillate.
double highest_frequency(const Motion& motion) {
  switch (motion.kind) {
    case Motion::Kind::sine:
      return motion.frequency;
    case Motion::Kind::sweep:
      return std::max(motion.frequency, motion.to_frequency);
    case Motion::Kind::random:
      return motion.psd_frequency.empty() ? 0.0 : motion.psd_frequency.back();
    default:
      return 0.0;
  }
}

/// Motion that the steps of the simulation cannot follow, and more or fewer samples than can be.
void append_rate_problems(const Plan& plan, Problems& problems) {
  const double rate = plan.sample_rate * oversampling_of(plan);
  for (const auto& segment : plan.schedule)
    for (const auto& [axis, motion] : segment.axes) {
      const double highest = highest_frequency(motion);
      const bool sine = motion.kind == Motion::Kind::sine;
      if (sine ? 2.0 * highest >= rate : 2.0 * highest > rate)
        problems.push_back(within(place_of_segment(segment.label),
                                  say("{} at {:.6g} Hz needs more than {:.6g} steps a second, and the simulation takes "
                                      "{:.6g}: raise [truth] oversampling",
                                      Name{axis}, highest, 2.0 * highest, rate)));
    }
  double samples = 0.0;
  for (const auto& segment : plan.schedule) samples += segment.duration * plan.sample_rate;
  if (!(samples <= most_samples)) {
    problems.push_back(say("the schedule makes {:.3g} samples a channel at {:.6g} Hz; {:.0e} are possible", samples,
                           plan.sample_rate, most_samples));
    return;
  }
  for (const auto& run : power_ups(plan.schedule, plan.sample_rate))
    if (run.samples == 0)
      problems.push_back(say("run {} is shorter than a sample at {:.6g} Hz", run.run, plan.sample_rate));
}

void refuse_incomplete(const Plan& plan) {
  Problems problems;
  if (plan.instrument_model.empty()) problems.push_back("to simulate, the plan needs [instrument] model = \"...\"");
  if (plan.rig_kind.empty()) problems.push_back("to simulate, the plan needs [rig] kind = \"...\"");
  if (!(plan.sample_rate > 0.0))
    problems.push_back("to simulate, the plan needs [instrument] rate = \"1 Hz\" or the like");
  if (plan.schedule.empty()) problems.push_back("to simulate, the plan needs at least one [[schedule]]");
  if (!plan.instrument_model.empty() && plan.truth.texts().empty())
    problems.push_back("to simulate, the plan needs [truth]");
  if (problems.empty()) {
    if (const Rig& rig = find_rig(plan.rig_kind); rig.refusals && recorded_one_by_one(plan))
      problems = rig.refusals(plan.schedule, plan.rig);  // a plan of files was asked about its segments one by one
    append_oversampling_problems(plan, problems);
    for (const auto& participant : participants_of(plan)) append_truth_problems(plan, participant, problems);
    append_rate_problems(plan, problems);
  }
  if (!plan.file.empty())
    for (auto& problem : problems) problem = in_file(plan.file, problem);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// All that a power-up records, the instrument's outputs first.
std::vector<Source> sources_of(const Plan& plan, const PlannedRun& run, const RandomStream& random) {
  const Reference reference = reference_of(plan, run, random);
  std::vector<Source> sources{outputs_of(plan, reference, run, random)};
  for (auto& sensor : sensors_of(plan, reference, run)) sources.push_back(std::move(sensor));
  return sources;
}

/// The channels of all sources, in order, without values.
std::vector<Channel> channels_of(const std::vector<Source>& sources) {
  std::vector<Channel> channels;
  for (const auto& source : sources)
    channels.insert(channels.end(), source.channels().begin(), source.channels().end());
  return channels;
}

/// The next `size` samples of source number s to where its channels stand, from sample `first` on.
void fill(std::vector<Source>& sources, std::size_t s, std::vector<Channel>& channels, std::size_t first,
          std::size_t size) {
  std::size_t c = 0;
  for (std::size_t before = 0; before < s; ++before) c += sources[before].channels().size();
  Samples out;
  for (std::size_t k = 0; k < sources[s].channels().size(); ++k)
    out.push_back(std::span(channels[c + k].values).subspan(first, size));
  sources[s].next(std::move(out));
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
  recording.meta = {
      {"title", plan.title}, {std::string(simulated_fact), "yes"}, {std::string(seed_fact), std::to_string(seed)}};
  if (!plan.instrument_serial.empty()) recording.meta[std::string(unit_fact)] = plan.instrument_serial;
  return recording;
}

std::size_t samples_of(const std::vector<PlannedRun>& runs) {
  std::size_t samples = 0;
  for (const auto& run : runs) samples += run.samples;
  return samples;
}

}  // namespace

Recording simulate(const Plan& plan, std::uint64_t seed, const Progress& progress) {
  refuse_incomplete(plan);
  const auto runs = power_ups(plan.schedule, plan.sample_rate);
  const RandomStream random(seed);
  report(progress, 0.0, "simulating");

  // One job a power-up and source.
  std::vector<std::vector<Source>> sources(runs.size());
  parallel_for(runs.size(), [&](std::size_t r) { sources[r] = sources_of(plan, runs[r], random); });
  Recording recording = frame_of(plan, seed);
  recording.channels = channels_of(sources.front());
  for (auto& channel : recording.channels) channel.values.resize(samples_of(runs));
  std::vector<std::size_t> first(runs.size(), 0);
  for (std::size_t r = 1; r < runs.size(); ++r) first[r] = first[r - 1] + runs[r - 1].samples;
  const std::size_t jobs = sources.front().size();
  parallel_for(runs.size() * jobs, [&](std::size_t job) {
    const std::size_t r = job / jobs, s = job % jobs;
    fill(sources[r], s, recording.channels, first[r], runs[r].samples);
  });
  report(progress, 1.0, "simulating");
  return recording;
}

void simulate(const Plan& plan, std::uint64_t seed, std::size_t samples,
              const std::function<void(const Recording& block)>& sink, const Progress& progress) {
  refuse_incomplete(plan);
  const auto runs = power_ups(plan.schedule, plan.sample_rate);
  const RandomStream random(seed);
  const auto all = static_cast<double>(samples_of(runs));
  std::size_t done = 0;
  for (const auto& run : runs) {
    auto sources = sources_of(plan, run, random);
    for (std::size_t first = 0; first < run.samples; first += samples) {
      report(progress, static_cast<double>(done) / all, "simulating");
      Recording block = done == 0 ? frame_of(plan, seed) : Recording{};
      const std::size_t size = std::min(samples, run.samples - first);
      block.channels = channels_of(sources);
      for (auto& channel : block.channels) {
        channel.timeline.start = runs.front().begin + static_cast<double>(done) / plan.sample_rate;
        channel.values.resize(size);
      }
      parallel_for(sources.size(), [&](std::size_t s) { fill(sources, s, block.channels, 0, size); });
      sink(block);
      done += size;
    }
  }
  report(progress, 1.0, "simulating");
}

std::size_t simulated_size(const Plan& plan) {
  refuse_incomplete(plan);
  const auto runs = power_ups(plan.schedule, plan.sample_rate);
  const Rig& rig = find_rig(plan.rig_kind);
  PlannedRun probe = runs.front();  // the first segment is enough to see which sensors there are
  probe.segments.resize(1);
  probe.segments.front().duration = 1.0 / plan.sample_rate;
  const auto sensors =
      rig.reference({probe.segments, plan.rig, plan.site, plan.sample_rate, {}, RandomStream(0)}).sensors;
  std::size_t channels = sensors.size();
  for (const auto& [prefix, model, truth, mount] : participants_of(plan)) channels += model.outputs(truth).size();
  return samples_of(runs) * channels * sizeof(double);
}

}  // namespace tumble
