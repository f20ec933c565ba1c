#include "tumble/methods/testing/trials.hpp"

#include <cmath>
#include <complex>

#include "tumble/language/say.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/methods/frequency_response/testing/trial.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::frequency_response {
namespace {

struct Truth {
  double gain = 1.012, natural = 45.0, damping = 0.55, delay = 1.5e-3;
  double group_delay() const { return delay + 2.0 * damping / (two_pi * natural); }
  std::complex<double> at(double f) const {
    const std::complex<double> i(0.0, 1.0);
    const double r = f / natural;
    return gain * std::exp(-i * two_pi * f * delay) / (1.0 - r * r + 2.0 * i * damping * r);
  }
};

struct Tone {
  double frequency, amplitude, duration;
};

const std::vector<Tone> tones{{2.0, 4.0, 6.0},   {4.0, 6.0, 5.0},   {8.0, 8.0, 4.0},   {12.5, 10.0, 4.0},
                              {20.0, 10.0, 4.0}, {31.5, 10.0, 4.0}, {40.0, 10.0, 4.0}, {50.0, 10.0, 4.0},
                              {63.0, 10.0, 4.0}, {80.0, 10.0, 4.0}};
constexpr double output_rate = 250.0, reference_rate = 400.0, window = 2e-3;
constexpr double clock_sd = 20e-6, gain_sd = 1e-3;

/// Adds the samples of a tone to a channel. Given: line, its complex amplitude.
void add(Channel& channel, const Tone& tone, double begin, double late, std::complex<double> line) {
  const auto first = static_cast<std::size_t>(std::ceil(begin * channel.timeline.rate));
  const auto last = static_cast<std::size_t>(std::ceil((begin + tone.duration) * channel.timeline.rate));
  for (std::size_t i = first; i < last && i < channel.values.size(); ++i)
    channel.values[i] +=
        (line * std::polar(1.0, two_pi * tone.frequency * 1.0003 * (channel.time(i) - begin - late))).real();
}

Plan plan_of(const std::vector<Option>& options) {
  Plan plan;
  plan.method = "frequency_response";
  plan.settings = defaults(options);
  plan.settings.set_number("averaging", window, Unit::parse("s"));
  plan.settings.set_number("clock_offset_sd", clock_sd, Unit::parse("s"));
  plan.settings.set_number("reference_gain_sd", gain_sd, Unit::parse("%"));
  for (const Tone& tone : tones) {
    Segment segment{std::to_string(tone.frequency) + " Hz", tone.duration, 1, {}};
    segment.axes["vibration"] = {.kind = Motion::Kind::sine, .amplitude = tone.amplitude, .frequency = tone.frequency};
    plan.schedule.push_back(segment);
  }
  return plan;
}

Recording recording_of(const Truth& truth, const Plan& plan, const RandomStream& random) {
  double time = 0.0;
  for (const Tone& tone : tones) time += tone.duration;
  const Unit unit = Unit::parse("m/s^2");
  Channel output{"output", QuantityKind::specific_force, unit, {0.0, output_rate, nullptr}, {}};
  Channel reference{"reference", QuantityKind::specific_force, unit, {0.0, reference_rate, nullptr}, {}};
  output.values.assign(static_cast<std::size_t>(time * output_rate), 9.8);
  reference.values.assign(static_cast<std::size_t>(time * reference_rate), 0.0);
  const double late = clock_sd * random.normal(0), wrong = 1.0 + gain_sd * random.normal(1);
  Recording recording;
  double begin = 0.0;
  for (std::size_t k = 0; k < tones.size(); ++k) {
    const Tone& tone = tones[k];
    const double f = 1.0003 * tone.frequency;
    recording.marks.push_back({plan.schedule[k].label, begin, 1});
    // The mean over a window is the value in its middle times sinc.
    add(output, tone, begin, late,
        tone.amplitude * truth.at(f) * vibration::sinc(f * window) * std::polar(1.0, pi * f * window));
    add(reference, tone, begin, 0.0, tone.amplitude * wrong);
    begin += tone.duration;
  }
  add_noise({.angle_random_walk = 0.002, .bias_instability = 0.01, .rate_random_walk = 0.05}, output_rate,
            random.split("output"), output.values);
  add_noise({.angle_random_walk = 0.0005}, reference_rate, random.split("reference"), reference.values);
  recording.channels = {std::move(output), std::move(reference)};
  return recording;
}

}  // namespace

Trial trial(std::uint64_t seed, const std::vector<Option>& options) {
  const Truth truth;
  Trial trial;
  trial.evidence.plan = plan_of(options);
  trial.evidence.recordings = {
      recording_of(truth, trial.evidence.plan, RandomStream(seed).split("frequency_response"))};
  for (const Tone& tone : tones)
    trial.truth.emplace_back("gain_" + frequency_label(tone.frequency), std::abs(truth.at(1.0003 * tone.frequency)));
  double phase = 0.0;
  for (const Tone& tone : tones) {
    const double now = std::arg(truth.at(1.0003 * tone.frequency));
    phase = now + two_pi * std::round((phase - now) / two_pi);
    trial.truth.emplace_back("phase_" + frequency_label(tone.frequency), phase);
  }
  const double a = 1.0 - 2.0 * truth.damping * truth.damping;
  trial.truth.emplace_back("bandwidth", truth.natural * std::sqrt(a + std::sqrt(a * a + 1.0)));
  trial.truth.emplace_back("natural_frequency", truth.natural);
  trial.truth.emplace_back("damping_ratio", truth.damping);
  trial.truth.emplace_back("delay", truth.delay);
  trial.truth.emplace_back("group_delay", truth.group_delay());
  return trial;
}

extern const Trials trials{
    [](std::uint64_t seed) { return trial(seed, find_method("frequency_response").options()); },
    [](std::uint64_t seed) { return second_trial(seed, find_method("frequency_response").options()); }};

}  // namespace tumble::frequency_response
