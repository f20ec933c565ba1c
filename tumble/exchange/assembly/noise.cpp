#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/core/roles.hpp"
#include "tumble/exchange/assembly/reader.hpp"

namespace tumble::assembly {
namespace {

/// The channels of a result, in their order, and whether each is a gyro.
std::vector<std::pair<std::string, bool>> channels_of(const Estimate& estimate) {
  std::vector<std::pair<std::string, bool>> channels;
  for (const auto& parameter : estimate.parameters) {
    const auto dot = parameter.name.rfind('.');
    if (dot == std::string::npos) continue;
    const std::string label = parameter.name.substr(0, dot), term = parameter.name.substr(dot + 1);
    const bool gyro = term == "angle_random_walk", force = term == "velocity_random_walk";
    const bool known = std::ranges::any_of(channels, [&](const auto& channel) { return channel.first == label; });
    if ((gyro || force) && !known) channels.emplace_back(label, gyro);
  }
  return channels;
}

/// The axes that each channel is: one, by its label; all three where there is one channel of a kind without an axis.
std::map<std::string, std::vector<std::size_t>> axes_of(Reader& reader,
                                                        const std::vector<std::pair<std::string, bool>>& channels) {
  std::map<std::string, std::vector<std::size_t>> axes;
  for (const bool gyro : {false, true}) {
    std::vector<std::string> labels;
    for (const auto& [label, is_gyro] : channels)
      if (is_gyro == gyro) labels.push_back(label);
    for (const auto& label : labels) {
      const auto axis = axis_named(label);
      if (axis) {
        axes[label] = {*axis};
      } else if (labels.size() == 1) {
        axes[label] = {0, 1, 2};
        reader.note(fmt::format("noise of {} is used for all three {}", label, gyro ? "gyros" : "accelerometers"));
      } else {
        reader.problem(
            say("of the channel {} the axis is not known (channels are {}): let its name say x, y or "
                "z, as gyro_x, ax_g or GyrX do",
                Name{label}, fmt::join(labels, ", ")));
      }
    }
  }
  return axes;
}

/// [Hz]: the curve of a channel begins at one sampling interval, unless the user listed the averaging times: then NaN,
/// as where there is no curve.
double rate_of(Reader& reader, const std::string& label) {
  const auto taus = reader.setting("taus");
  const auto named = {"log", "octave", "decade", "all"};
  const auto& curves = reader.estimate().curves;
  const auto curve = std::ranges::find(curves, label + " allan_deviation", &Curve::name);
  if (std::ranges::find(named, taus) == named.end() || curve == curves.end() || curve->x.values.empty())
    return std::nan("");
  return std::round(1e9 / curve->x.values.front()) / 1e9;
}

/// A standard deviation or its density; a negative one is a problem. NaN where the result lacks it.
double size_of(Reader& reader, const std::string& name) {
  const double value = reader.value_or(name, AxisNoise::none);
  if (value < 0.0) reader.problem(say("the parameter '{}' is negative: a noise is not", name));
  return value;
}

AxisNoise noise_of(Reader& reader, const std::string& label, bool gyro) {
  const std::string walk = label + (gyro ? ".rate_random_walk" : ".acceleration_random_walk");
  AxisNoise noise;
  noise.rate = rate_of(reader, label);
  noise.white = size_of(reader, label + (gyro ? ".angle_random_walk" : ".velocity_random_walk"));
  noise.walk = size_of(reader, walk);
  noise.instability = size_of(reader, label + ".bias_instability");
  noise.markov_sd = size_of(reader, label + ".markov_sd");
  noise.markov_time = size_of(reader, label + ".markov_time");
  if (const auto limit = find_upper_limit(reader.estimate(), walk)) noise.walk_limit = limit->value;
  return noise;
}

}  // namespace

bool read_noise(Reader& reader, std::set<std::string>& claimed) {
  const auto channels = channels_of(reader.estimate());
  if (channels.empty()) return false;
  const auto axes = axes_of(reader, channels);
  for (const auto& [label, gyro] : channels) {
    const auto own = axes.find(label);
    if (own == axes.end()) continue;
    for (const std::size_t axis : own->second) {
      reader.claim(role(gyro, axis) + " noise", claimed);
      triad(reader.calibration(), gyro).noise[axis] = noise_of(reader, label, gyro);
    }
  }
  return true;
}

}  // namespace tumble::assembly
