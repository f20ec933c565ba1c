#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "tumble/language/say.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/methods/frequency_response/testing/trial.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/units/constants.hpp"

// Against the first trial: the output is reversed, its clock is late, its delay is negative and its loop does not peak;
// tones are measured three times, seated anew each time, and two of them once; samples are missing, a tenth of a tone
// in one piece; an offset of the other sign, other rates, no averaging but stamps at the beginning.

namespace tumble::frequency_response {
namespace {

constexpr double loop_gain = 0.97, natural_frequency = 60.0, damping_ratio = 0.9, lead = -0.4e-3;
constexpr double rate_of_output = 500.0, rate_of_reference = 300.0, clock_late = 2e-3, clock_late_sd = 10e-6;
constexpr double seat_gain = 4e-3, seat_phase = 5e-3;  ///< [1], [rad] scatter from one seating to the next
constexpr double missing_share = 0.03;
constexpr int times = 3;

const std::vector<double> frequencies{3.0, 6.0, 11.0, 17.0, 23.0, 37.0, 47.0, 71.0, 90.0};
const std::vector<double> measured_once{6.0, 71.0};

struct Visit {
  double frequency = 0.0, begin = 0.0, duration = 0.0;
};

std::vector<Visit> visits() {
  std::vector<Visit> all;
  double begin = 0.0;
  for (int k = 0; k < times; ++k)
    for (const double f : frequencies) {
      if (k > 0 && std::ranges::find(measured_once, f) != measured_once.end()) continue;
      const double duration = f < 5.0 ? 6.0 : 3.0;
      all.push_back({f, begin, duration});
      begin += duration;
    }
  return all;
}

std::complex<double> reversed_loop(double f) {
  const std::complex<double> i(0.0, 1.0);
  const double r = f / natural_frequency;
  return -loop_gain * std::exp(-i * two_pi * f * lead) / (1.0 - r * r + 2.0 * i * damping_ratio * r);
}

Plan second_plan(const std::vector<Option>& options) {
  Plan plan;
  plan.method = "frequency_response";
  plan.settings = defaults(options);
  plan.settings.set_word("stamps", "begin");
  plan.settings.set_number("clock_offset", clock_late, Unit::parse("s"));
  plan.settings.set_number("clock_offset_sd", clock_late_sd, Unit::parse("s"));
  int number = 0;
  for (const Visit& visit : visits()) {
    Segment segment{fmt::format("{} Hz #{}", visit.frequency, ++number), visit.duration, 1, {}};
    segment.axes["vibration"] = {.kind = Motion::Kind::sine, .amplitude = 8.0, .frequency = visit.frequency};
    plan.schedule.push_back(segment);
  }
  return plan;
}

/// Adds a tone to the samples of one visit, which are instants in the middle of their intervals.
void add_visit(Channel& channel, const Visit& visit, double late, std::complex<double> line) {
  const double rate = channel.timeline.rate;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    const double t = channel.time(i) - late + 0.5 / rate;
    if (t < visit.begin || t >= visit.begin + visit.duration) continue;
    channel.values[i] += (line * std::polar(1.0, two_pi * visit.frequency * (t - visit.begin))).real();
  }
}

/// Samples missing here and there, and three tenths of a second at once.
void lose_samples(const RandomStream& random, Channel& channel) {
  const double rate = channel.timeline.rate;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    const double t = static_cast<double>(i) / rate;
    if (random.uniform(i) < missing_share || (t > 8.0 && t < 8.3)) channel.values[i] = std::nan("");
  }
}

Recording second_recording(const Plan& plan, const RandomStream& random) {
  const Unit unit = Unit::parse("m/s^2");
  const auto all = visits();
  const double time = all.back().begin + all.back().duration, late = clock_late + clock_late_sd * random.normal(0);
  Channel output{"output", QuantityKind::specific_force, unit, {late, rate_of_output, nullptr}, {}};
  Channel reference{"reference", QuantityKind::specific_force, unit, {0.0, rate_of_reference, nullptr}, {}};
  output.values.assign(static_cast<std::size_t>(time * rate_of_output), -3.0);
  reference.values.assign(static_cast<std::size_t>(time * rate_of_reference), 0.2);
  Recording recording;
  for (std::size_t k = 0; k < all.size(); ++k) {
    recording.marks.push_back({plan.schedule[k].label, all[k].begin, 1});
    const std::complex<double> seat(seat_gain * random.normal(2 * k + 1), seat_phase * random.normal(2 * k + 2));
    add_visit(output, all[k], late, 8.0 * reversed_loop(all[k].frequency) * std::exp(seat));
    add_visit(reference, all[k], 0.0, 8.0);
  }
  add_noise({.angle_random_walk = 0.003, .bias_instability = 0.02}, rate_of_output, random.split("output"),
            output.values);
  add_noise({.angle_random_walk = 0.001}, rate_of_reference, random.split("reference"), reference.values);
  lose_samples(random.split("lost of output"), output);
  lose_samples(random.split("lost of reference"), reference);
  recording.channels = {std::move(output), std::move(reference)};
  return recording;
}

}  // namespace

Trial second_trial(std::uint64_t seed, const std::vector<Option>& options) {
  Trial trial;
  trial.evidence.plan = second_plan(options);
  trial.evidence.recordings = {
      second_recording(trial.evidence.plan, RandomStream(seed).split("frequency_response, second"))};
  double before = 0.0;
  for (const double f : frequencies) {
    trial.truth.emplace_back("gain_" + frequency_label(f), std::abs(reversed_loop(f)));
    const double now = std::arg(-reversed_loop(f));
    before = now + two_pi * std::round((before - now) / two_pi);
    trial.truth.emplace_back("phase_" + frequency_label(f), before + pi);
  }
  const double a = 1.0 - 2.0 * damping_ratio * damping_ratio;
  trial.truth.emplace_back("bandwidth", natural_frequency * std::sqrt(a + std::sqrt(a * a + 1.0)));
  trial.truth.emplace_back("natural_frequency", natural_frequency);
  trial.truth.emplace_back("damping_ratio", damping_ratio);
  trial.truth.emplace_back("delay", lead);
  trial.truth.emplace_back("group_delay", lead + 2.0 * damping_ratio / (two_pi * natural_frequency));
  return trial;
}

}  // namespace tumble::frequency_response
