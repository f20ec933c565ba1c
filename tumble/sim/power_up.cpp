#include "tumble/sim/power_up.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace tumble::sim {
namespace {

constexpr std::size_t steps_at_once = 2048;  ///< small enough that a block stays in the first caches

int oversampling_of(const Plan& plan) { return std::max(1, plan.truth.integer("oversampling")); }

/// The terms of one output that are not zero.
struct Sum {
  std::function<double(const Felt&)> input;
  std::vector<Term> terms;
  std::vector<double> coefficients;

  double operator()(const Felt& felt) const {
    double value = input ? input(felt) : 0.0;
    for (std::size_t t = 0; t < terms.size(); ++t) value += coefficients[t] * terms[t].regressor(felt);
    return value;
  }
};

Sum sum_of(const Model& model, const Output& output, const Settings& truth) {
  Sum sum{output.input, {}, {}};
  const auto coefficients = coefficients_of(model, output, truth);
  for (std::size_t t = 0; t < output.terms.size(); ++t)
    if (coefficients[t] != 0.0) {
      sum.terms.push_back(output.terms[t]);
      sum.coefficients.push_back(coefficients[t]);
    }
  return sum;
}

/// One output of the instrument: what it indicates at every step, through its electronics into samples.
class Producer {
 public:
  Producer(Sum sum, Reference reference, double turn_on, NoiseSource noise, Recorded recorded, double step,
           int oversampling)
      : sum_(std::move(sum)),
        reference_(std::move(reference)),
        turn_on_(turn_on),
        noise_(std::move(noise)),
        recorded_(std::move(recorded)),
        step_(step),
        oversampling_(static_cast<std::size_t>(oversampling)),
        felt_(steps_at_once) {}

  void operator()(std::span<double> samples) {
    const std::size_t at_once = std::max<std::size_t>(1, steps_at_once / oversampling_);
    while (!samples.empty()) {
      const auto part = samples.first(std::min(at_once, samples.size()));
      if (oversampling_ == 1) {
        steps(part);
      } else {
        fine_.resize(part.size() * oversampling_);
        steps(fine_);
        gather(part);
      }
      samples = samples.subspan(part.size());
    }
  }

 private:
  void steps(std::span<double> block) {
    indicate(block);
    noise_.add(block);
    if (recorded_.response) recorded_.response(block);
    done_ += block.size();
  }

  /// Input and terms. Where what is felt does not change and the terms do not either, one evaluation is enough.
  void indicate(std::span<double> block) {
    const double first = (static_cast<double>(done_) + 0.5) * step_;
    const double last = first + static_cast<double>(block.size() - 1) * step_;
    felt_.resize(std::max(felt_.size(), block.size()));
    if (!recorded_.history && reference_.steady_until && reference_.steady_until(first) >= last) {
      Felt ends[2];
      reference_.felt(first, last - first, std::span(ends).first(1));
      ends[1] = ends[0];
      ends[1].since_power_on += last - first;
      const double at_begin = sum_(ends[0]), at_end = sum_(ends[1]);
      if (at_begin == at_end) {
        std::fill(block.begin(), block.end(), at_begin + turn_on_);
        return;
      }
    }
    const auto felt = std::span(felt_).first(block.size());
    reference_.felt(first, step_, felt);
    for (std::size_t k = 0; k < block.size(); ++k) block[k] = sum_(felt[k]) + turn_on_;
    if (recorded_.history) recorded_.history(felt, block);
  }

  void gather(std::span<double> samples) const {
    const double scale = recorded_.accumulates ? 1.0 : 1.0 / static_cast<double>(oversampling_);
    for (std::size_t k = 0; k < samples.size(); ++k) {
      double sum = 0.0;
      for (std::size_t i = 0; i < oversampling_; ++i) sum += fine_[k * oversampling_ + i];
      samples[k] = scale * sum;
    }
  }

  Sum sum_;
  Reference reference_;
  double turn_on_;
  NoiseSource noise_;
  Recorded recorded_;
  double step_;
  std::size_t oversampling_;
  std::size_t done_ = 0;
  std::vector<Felt> felt_;
  std::vector<double> fine_;
};

}  // namespace

std::vector<PowerUp> power_ups(const Schedule& schedule, double sample_rate) {
  std::vector<PowerUp> out;
  double now = 0.0;
  for (const auto& segment : schedule) {
    if (out.empty() || out.back().run != segment.run) out.push_back({segment.run, now, 0, {}});
    out.back().segments.push_back(segment);
    now += segment.duration;
    out.back().samples = static_cast<std::size_t>(std::llround((now - out.back().begin) * sample_rate));
  }
  return out;
}

Matrix drawn_errors(const std::vector<RigError>& errors, std::size_t segments, const RandomStream& test,
                    const RandomStream& run) {
  if (errors.empty()) return {};
  Matrix drawn(errors.size(), segments);
  for (std::size_t e = 0; e < errors.size(); ++e) {
    const RandomStream whole = test.split(errors[e].name), each = run.split(errors[e].name);
    for (std::size_t s = 0; s < segments; ++s)
      drawn(e, s) = errors[e].sd * (errors[e].each_segment ? each.normal(s) : whole.normal(0));
  }
  return drawn;
}

Reference reference_of(const Plan& plan, const PowerUp& run, const RandomStream& random) {
  const Rig& rig = find_rig(plan.rig_kind);
  const RandomStream own = random.split("run").split(static_cast<std::uint64_t>(run.run)).split("rig");
  Matrix errors =
      drawn_errors(rig.errors(plan.rig), run.segments.size(), random.split("rig errors"), own.split("errors"));
  return rig.reference(
      {run.segments, plan.rig, plan.site, plan.sample_rate * oversampling_of(plan), std::move(errors), own});
}

std::vector<Source> outputs_of(const Plan& plan, const Reference& reference, const PowerUp& run,
                               const RandomStream& random) {
  const Model& model = find_model(plan.instrument_model);
  const auto outputs = model.outputs(plan.truth);
  const int oversampling = oversampling_of(plan);
  const double rate = plan.sample_rate * oversampling;
  const RandomStream instrument = random.split("run").split(static_cast<std::uint64_t>(run.run)).split("instrument");
  std::vector<Source> sources;
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    const Output& output = outputs[k];
    const RandomStream own = outputs.size() == 1 ? instrument : instrument.split(output.channel);
    Recorded recorded{output.kind, output.unit, false, nullptr};
    if (model.record) recorded = model.record(plan.truth, k, 1.0 / rate, own.split("electronics"));
    const double turn_on =
        plan.truth.number(output.noise_prefix + "turn_on_repeatability") * own.split("turn-on").normal(0);
    const NoiseSource noise(noise_of(plan.truth, output.noise_prefix), rate,
                            run.samples * static_cast<std::size_t>(oversampling), own.split("noise"));
    Channel channel{
        output.channel, recorded.kind, Unit::parse(recorded.unit), {run.begin, plan.sample_rate, nullptr}, {}};
    sources.push_back({std::move(channel), Producer(sum_of(model, output, plan.truth), reference, turn_on, noise,
                                                    std::move(recorded), 1.0 / rate, oversampling)});
  }
  return sources;
}

std::vector<Source> sensors_of(const Plan& plan, const Reference& reference, const PowerUp& run) {
  std::vector<Source> sources;
  for (const auto& sensor : reference.sensors) {
    Channel channel = sensor.channel;
    channel.timeline = {run.begin, plan.sample_rate, nullptr};
    const double step = 1.0 / plan.sample_rate;
    sources.push_back(
        {std::move(channel), [read = sensor.read, step, done = std::size_t{0}](std::span<double> out) mutable {
           read((static_cast<double>(done) + 0.5) * step, step, out);
           done += out.size();
         }});
  }
  return sources;
}

}  // namespace tumble::sim
