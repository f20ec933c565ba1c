#include "tumble/checks/support/signals.hpp"

#include <algorithm>
#include <string_view>

namespace tumble::support {

namespace {

bool names_a_sensor(std::string_view name) {
  return name.find("gyro") != std::string_view::npos || name.find("accelerometer") != std::string_view::npos;
}

/// Whether a role of that name may be played by what a sensor puts out.
bool is_of_a_sensor(std::string_view role) { return role == "signal" || role == "output" || names_a_sensor(role); }

}  // namespace

bool is_signal(const Channel& channel, const Plan* plan) {
  using enum QuantityKind;
  if (channel.name.ends_with("set_point")) return false;
  if (channel.kind == angular_rate || channel.kind == specific_force || channel.kind == velocity ||
      channel.kind == count)
    return true;
  if (channel.kind == temperature || channel.kind == time) return false;  // an angle may be the increment of a gyro
  if (names_a_sensor(channel.name)) return true;
  return plan != nullptr && std::ranges::any_of(plan->channels, [&](const auto& role) {
           return is_of_a_sensor(role.first) &&
                  std::ranges::find(role.second, channel.name, &ChannelChoice::channel) != role.second.end();
         });
}

}  // namespace tumble::support
