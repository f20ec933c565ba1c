#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "tumble/math/parallel.hpp"
#include "tumble/math/step_means.hpp"
#include "tumble/rigs/felt_courses.hpp"
#include "tumble/sim/instrument_run.hpp"
#include "tumble/sim/power_up.hpp"

namespace tumble {
namespace simulated {  // named, since State of InstrumentRun has them as members

/// Steps that are simulated at once: of one output so few that they stay in the first caches; of several, which share
/// what is felt, enough to be worth a thread each.
constexpr std::size_t steps_of_one = 2048, steps_of_several = 16384;

/// What one output indicates of what is felt: its input and those of its terms that are not zero.
struct Sum {
  Regressor input;
  std::vector<Term> terms;
  std::vector<double> coefficients;
  std::optional<Rotation> mount;  ///< its axes, where they are not those in which the rig says what is felt

  double operator()(const Felt& felt) const { return mount ? sum(turned(felt)) : sum(felt); }

  Felt turned(const Felt& felt) const {
    Felt own = felt;
    own.rate = *mount * felt.rate;
    own.angular_acceleration = *mount * felt.angular_acceleration;
    own.specific_force = *mount * felt.specific_force;
    return own;
  }

 private:
  double sum(const Felt& felt) const {
    double value = input ? input(felt) : 0.0;
    for (std::size_t t = 0; t < terms.size(); ++t) value += coefficients[t] * terms[t].regressor(felt);
    return value;
  }
};

Sum sum_of(const Model& model, const Output& output, const Settings& truth, const std::optional<Rotation>& mount) {
  Sum sum{output.input, {}, {}, mount};
  const auto coefficients = coefficients_of(model, output, truth);
  for (std::size_t t = 0; t < output.terms.size(); ++t)
    if (coefficients[t] != 0.0) {
      sum.terms.push_back(output.terms[t]);
      sum.coefficients.push_back(coefficients[t]);
    }
  return sum;
}

/// Steps within one segment: what is felt may change its course at once from a segment to the next.
struct Piece {
  std::size_t begin = 0, end = 0;
};

/// One output: what it indicates at every step, through its electronics into samples.
struct Producer {
  Sum sum;
  double turn_on;
  NoiseSource noise;
  Recorded recorded;
  std::vector<double> fine = {};     ///< steps, where a sample takes more than one
  std::vector<double> middles = {};  ///< what it indicates in the middle of each step, and beside the first and last
  std::vector<Felt> own = {};        ///< what is felt in the axes of an instrument mounted otherwise

  /// What it indicates at every step, noise apart, if that is one number from `begin` to `end`.
  std::optional<double> constant(const Felt& begin, const Felt& end) const {
    if (recorded.history) return std::nullopt;
    const double value = sum(begin);
    if (value != sum(end)) return std::nullopt;
    return value;
  }

  /// `felt` is not looked at where `constant` has a value; else it begins `before` steps in front of the first.
  void fill(const std::optional<double>& constant, std::span<const Felt> felt, std::span<const StepCourse> courses,
            std::span<const Piece> pieces, std::size_t before, std::size_t oversampling, std::span<double> samples) {
    fine.resize(oversampling == 1 ? 0 : samples.size() * oversampling);
    const auto steps = oversampling == 1 ? samples : std::span(fine);
    if (constant) {
      for (double& step : steps) step = *constant + turn_on;
    } else {
      middles.resize(felt.size());
      for (std::size_t k = 0; k < felt.size(); ++k) middles[k] = sum(felt[k]) + turn_on;
      for (const Piece& piece : pieces) {
        const std::size_t from = std::max(piece.begin, before), to = std::min(piece.end, before + steps.size());
        if (from >= to) continue;
        means_from_middles(std::span(middles).subspan(piece.begin, piece.end - piece.begin),
                           courses.subspan(piece.begin, piece.end - piece.begin), from - piece.begin,
                           steps.subspan(from - before, to - from));
      }
    }
    if (recorded.history) {
      const auto own_steps = felt.subspan(before, steps.size());
      recorded.history(sum.mount ? turned(own_steps) : own_steps, steps);
    }
    noise.add(steps);
    if (recorded.response) recorded.response(steps);
    if (oversampling > 1) gather(oversampling, samples);
  }

  std::span<const Felt> turned(std::span<const Felt> felt) {
    own.clear();
    for (const Felt& one : felt) own.push_back(sum.turned(one));
    return own;
  }

  void gather(std::size_t oversampling, std::span<double> samples) const {
    const double scale = recorded.accumulates ? 1.0 : 1.0 / static_cast<double>(oversampling);
    for (std::size_t k = 0; k < samples.size(); ++k) {
      double total = 0.0;
      for (std::size_t i = 0; i < oversampling; ++i) total += fine[k * oversampling + i];
      samples[k] = scale * total;
    }
  }
};

}  // namespace simulated

using namespace simulated;

/// All outputs of one power-up.
struct InstrumentRun::State {
  double rate = 1.0, step = 1.0;  ///< [Hz], [s]
  std::size_t oversampling = 1;
  std::vector<Channel> channels = {};
  std::vector<Producer> outputs = {};
  Reference reference = {};
  std::size_t all_steps = 0;  ///< of the power-up
  std::vector<Felt> felt = {};
  std::vector<std::size_t> borders = {};   ///< steps at which segments begin, rising
  std::vector<bool> smooth_segments = {};  ///< see goes_on()
  std::vector<Piece> pieces = {};          ///< of `felt`, one a segment
  std::vector<StepCourse> courses = {};    ///< of `felt`

  void make(std::size_t first, const Samples& out) {
    const std::size_t steps = out.front().size() * oversampling;
    const double begin = (static_cast<double>(first * oversampling) + 0.5) * step;
    const auto constants = constants_from(begin, begin + static_cast<double>(steps - 1) * step);
    const bool several = outputs.size() > 1 && steps >= steps_of_one;
    const std::size_t at = first * oversampling, before = std::min(step_margin, at);
    const std::size_t after = std::min(step_margin, std::max(all_steps, at + steps) - at - steps);
    if (std::any_of(constants.begin(), constants.end(), [](const auto& constant) { return !constant; }))
      feel(at - before, before + steps + after, several);
    const auto fill = [&](std::size_t k) {
      outputs[k].fill(constants[k], felt, courses, pieces, before, oversampling, out[k]);
    };
    if (several) return parallel_for(outputs.size(), fill);
    for (std::size_t k = 0; k < outputs.size(); ++k) fill(k);
  }

  /// Where what is felt does not change and the terms do not either, one evaluation is enough.
  std::vector<std::optional<double>> constants_from(double begin, double end) const {
    std::vector<std::optional<double>> constants(outputs.size());
    if (!reference.steady_until || reference.steady_until(begin) < end) return constants;
    Felt at_begin;
    reference.felt(begin, end - begin, std::span(&at_begin, 1));
    Felt at_end = at_begin;
    at_end.since_power_on += end - begin;
    for (std::size_t k = 0; k < outputs.size(); ++k) constants[k] = outputs[k].constant(at_begin, at_end);
    return constants;
  }

  void feel(std::size_t first, std::size_t steps, bool several) {
    const double begin = (static_cast<double>(first) + 0.5) * step;
    felt.resize(steps);
    const auto part = [&](std::size_t p) {
      const std::size_t from = p * steps_of_one, size = std::min(steps_of_one, steps - from);
      reference.felt(begin + static_cast<double>(from) * step, step, std::span(felt).subspan(from, size));
    };
    const std::size_t parts = (steps + steps_of_one - 1) / steps_of_one;
    if (several)
      parallel_for(parts, part);
    else
      for (std::size_t p = 0; p < parts; ++p) part(p);
    pieces.clear();
    courses.clear();
    for (std::size_t from = first; from < first + steps;) {
      const auto border = std::ranges::upper_bound(borders, from);
      const std::size_t to = border == borders.end() ? first + steps : std::min(first + steps, *border);
      pieces.push_back({from - first, to - first});
      const bool smooth = smooth_segments[static_cast<std::size_t>(border - borders.begin()) - 1];
      const auto part_of = smooth ? courses_of(std::span<const Felt>(felt).subspan(from - first, to - from))
                                  : std::vector<StepCourse>(to - from, StepCourse::kinked);
      courses.insert(courses.end(), part_of.begin(), part_of.end());
      from = to;
    }
  }
};

InstrumentRun::InstrumentRun(const Plan& plan, const PlannedRun& run, const RandomStream& random)
    : state_(std::make_unique<State>()) {
  state_->oversampling = static_cast<std::size_t>(oversampling_of(plan));
  const double rate = plan.sample_rate * static_cast<double>(state_->oversampling);
  state_->rate = rate;
  state_->step = 1.0 / rate;
  const RandomStream of_run = random.split("run").split(static_cast<std::uint64_t>(run.run));
  for (const auto& [prefix, model, truth, own_from_first] : participants_of(plan)) {
    const bool as_first = own_from_first.x.x == 1.0 && own_from_first.y.y == 1.0 && own_from_first.z.z == 1.0;
    const auto mount = as_first ? std::nullopt : std::optional(own_from_first);
    const RandomStream own = of_run.split(prefix.empty() ? "instrument" : "beside " + prefix);
    const auto outputs = model.outputs(truth);
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      const Output& output = outputs[k];
      const RandomStream stream = outputs.size() == 1 ? own : own.split(output.channel);
      Recorded recorded{output.kind, output.unit, false, nullptr};
      if (model.record) recorded = model.record(truth, k, 1.0 / rate, stream.split("electronics"));
      state_->channels.push_back({prefix + output.channel,
                                  recorded.kind,
                                  Unit::parse(recorded.unit),
                                  {run.begin, plan.sample_rate, nullptr},
                                  {}});
      state_->outputs.push_back(
          {sum_of(model, output, truth, mount),
           truth.number(output.noise_prefix + "turn_on_repeatability") * stream.split("turn-on").normal(0),
           NoiseSource(noise_of(truth, output.noise_prefix), rate, run.samples * state_->oversampling,
                       stream.split("noise")),
           std::move(recorded)});
    }
  }
}

InstrumentRun::InstrumentRun(const InstrumentRun& other) : state_(std::make_unique<State>(*other.state_)) {}
InstrumentRun::InstrumentRun(InstrumentRun&&) noexcept = default;
InstrumentRun& InstrumentRun::operator=(const InstrumentRun& other) {
  if (this != &other) state_ = std::make_unique<State>(*other.state_);
  return *this;
}
InstrumentRun& InstrumentRun::operator=(InstrumentRun&&) noexcept = default;
InstrumentRun::~InstrumentRun() = default;

const std::vector<Channel>& InstrumentRun::channels() const { return state_->channels; }

std::size_t InstrumentRun::portion() const {
  const std::size_t steps = state_->channels.size() == 1 ? steps_of_one : steps_of_several;
  return std::max<std::size_t>(1, steps / state_->oversampling);
}

void InstrumentRun::follow(const Reference& reference, const Schedule& segments, std::size_t samples) {
  state_->reference = reference;
  state_->all_steps = samples * state_->oversampling;
  state_->borders.clear();
  state_->smooth_segments.clear();
  double border = 0.0;
  for (const auto& segment : segments) {
    state_->borders.push_back(static_cast<std::size_t>(std::llround(border * state_->rate)));
    state_->smooth_segments.push_back(goes_on(segment));
    border += segment.duration;
  }
}

void InstrumentRun::make(std::size_t first, const Samples& out) { state_->make(first, out); }

Source outputs_of(const Plan& plan, const Reference& reference, const PlannedRun& run, const RandomStream& random) {
  const auto instruments = std::make_shared<InstrumentRun>(plan, run, random);
  instruments->follow(reference, run.segments, run.samples);
  return {instruments->channels(), run.samples, instruments->portion(),
          [instruments](std::size_t first, const Samples& out) { instruments->make(first, out); }};
}

}  // namespace tumble
