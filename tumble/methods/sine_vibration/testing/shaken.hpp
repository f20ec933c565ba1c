#pragma once

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tumble/methods/testing/answer.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

/// Short tests without noise for the method sine_vibration.
namespace tumble::testing {

inline const Method& sine_method() { return find_method("sine_vibration"); }

struct Tone {
  double frequency, amplitude;
};

struct Shaken {
  std::vector<Tone> tones{{10.0, 3.0}, {40.0, 3.0}, {130.0, 3.0}};
  double scale = 20000.0;  ///< [pulse/s/g]
  bool rests = true;
  double rest = 4.0, duration = 6.5;
  std::function<void(Plan&)> change = {};
};

/// The test of `how` without noise, on an ideal rig, and what was counted.
inline Evidence shaken(const Shaken& how) {
  Plan plan = trial_plan("sine_vibration", sine_method().options(), "pendulous_accelerometer", "shaker", 200.0);
  plan.rig.set_flag("ideal", true);
  plan.truth.set_word("output", "count");
  set_truth(plan, "pulse_scale_factor", how.scale, "pulse/s/g");
  set_truth(plan, "second_order_coefficient", 20.0, "ug/g^2");
  plan.truth.set_integer("oversampling", 64);
  plan.settings.set_word("scale_factor", fmt::format("{} pulse/s/g", how.scale));
  int n = 0;
  const auto rest = [&] {
    if (how.rests) plan.schedule.push_back({fmt::format("rest {}", n++), how.rest, 1, {}});
  };
  for (const Tone& tone : how.tones) {
    rest();
    Segment segment{fmt::format("tone {}", n), how.duration, 1, {}};
    if (!how.rests) segment.label = fmt::format("tone {}", ++n);
    segment.axes["shake"] = {
        .kind = Motion::Kind::sine, .amplitude = si(tone.amplitude, "g"), .frequency = tone.frequency};
    plan.schedule.push_back(std::move(segment));
  }
  rest();
  if (how.change) how.change(plan);
  Recording recording = simulate(plan, 5, {});
  return {std::move(plan), {std::move(recording)}};
}

inline Channel& counts(Evidence& evidence) {
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "accelerometer") return channel;
  throw std::runtime_error("no accelerometer");
}

/// A cell of the table `response` in SI.
inline double cell(const Estimate& estimate, std::size_t row, const char* column) {
  const Table* table = find_table(estimate, "response");
  for (std::size_t c = 0; c < table->columns.size(); ++c)
    if (table->columns[c].name == column) return std::get<double>(table->rows.at(row)[c]);
  return std::nan("");
}

}  // namespace tumble::testing
