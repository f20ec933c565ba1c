#include <algorithm>
#include <cmath>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"

namespace tumble::entries {
namespace {

/// What an axis does with an output, from the angles of its encoder: the function gets the angle [rad] and the rate [rad/s],
/// and gives what is added.
void add_by_angle(const Plan& plan, Recordings& recordings, const std::string& name,
                  const std::function<double(double angle, double rate)>& added) {
  const std::vector<std::string> axes = encoders(plan, recordings);
  for (Recording& recording : recordings) {
    const Channel* encoder = axes.empty() ? nullptr : find_channel(recording, axes.back());
    if (encoder == nullptr || encoder->values.size() < 2) continue;
    const std::vector<double> angles = encoder->values;
    const double per_second = mean_rate(*encoder);
    for (Channel& channel : recording.channels)
      for (std::size_t i = 0; channel.name == name && i < channel.values.size(); ++i) {
        const std::size_t next = std::clamp<std::size_t>(i + 1, 1, angles.size() - 1);
        channel.values[i] += added(angles[next], (angles[next] - angles[next - 1]) * per_second);
      }
  }
}

/// Outputs that are no counts, beside an axis whose angles are recorded at the same rate.
std::vector<std::string> on_an_axis(const Plan& plan, const Recordings& recordings) {
  const std::vector<std::string> axes = encoders(plan, recordings);
  std::vector<std::string> names = axes.empty() ? std::vector<std::string>{} : outputs(plan, recordings);
  std::erase_if(names, [&](const std::string& name) {
    return std::ranges::any_of(recordings, [&](const Recording& recording) {
      const Channel *output = find_channel(recording, name), *encoder = find_channel(recording, axes.back());
      return output != nullptr && (output->kind == QuantityKind::count || encoder == nullptr ||
                                   encoder->values.size() != output->values.size());
    });
  });
  return names;
}

/// The motor of the inner axis heats with the square of its rate; the instrument follows in a hundredth of the record.
void heat_by_motor(const Plan& plan, Recordings& recordings, const Happening& what) {
  double greatest = 0.0, heat = 0.0, samples = 0.0;
  const auto measure = [&](double, double rate) {
    greatest = std::max(greatest, std::abs(rate));
    samples += 1.0;
    return 0.0;
  };
  add_by_angle(plan, recordings, what.target, measure);
  if (!(greatest > 0.0)) return;
  const double share = 100.0 / samples;
  add_by_angle(plan, recordings, what.target, [&](double, double rate) {
    const double power = rate / greatest * rate / greatest;
    heat += std::min(1.0, share) * (power - heat);
    return what.size * heat;
  });
}

void point_like_a_compass(const Plan& plan, Recordings& recordings, const Happening& what) {
  add_by_angle(plan, recordings, what.target, [&](double angle, double) { return what.size * std::cos(angle); });
}

}  // namespace

std::vector<Departure> of_surroundings() {
  return {{.name = "motor_heat",
           .summary = "the power of the rig's motor warms one side of the instrument, and its bias follows",
           .targets = on_an_axis,
           .told_by = {"gradient_follows_rate", "segment_still_changes", "output_drifts_within_segments",
                       "segments_differ_from_model"},
           .covered = covered_bias,
           .record = heat_by_motor},
          {.name = "magnetic",
           .summary = "an output depends on the direction of the Earth's magnetic field, through the angle of an axis",
           .targets = on_an_axis,
           .told_by = {"earth_rate_differs", "gyro_gain_far_from_stated", "output_follows_axis",
                       "segments_differ_from_model", "positions_off_circle", "reference_relation_differs",
                       "line_beside_force"},
           .covered = covered_bias,
           .record = point_like_a_compass}};
}

}  // namespace tumble::entries
