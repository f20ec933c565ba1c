#include "tumble/core/error_model.hpp"

#include <algorithm>
#include <array>

namespace tumble {
namespace {

struct Row {
  const char* name;
  const char* unit;
};

constexpr std::array<Row, 16> rows{{{"rate_x", "rad/s"},
                                    {"rate_y", "rad/s"},
                                    {"rate_z", "rad/s"},
                                    {"angular_acceleration_x", "rad/s^2"},
                                    {"angular_acceleration_y", "rad/s^2"},
                                    {"angular_acceleration_z", "rad/s^2"},
                                    {"specific_force_x", "m/s^2"},
                                    {"specific_force_y", "m/s^2"},
                                    {"specific_force_z", "m/s^2"},
                                    {"temperature", "K"},
                                    {"temperature_gradient", "K"},
                                    {"temperature_rate", "K/s"},
                                    {"start_temperature", "K"},
                                    {"since_power_on", "s"},
                                    {"angle", "rad"},
                                    {"channel", "1"}}};

}  // namespace

const char* name(Input input) { return rows[static_cast<std::size_t>(input)].name; }

const char* unit_of(Input input) { return rows[static_cast<std::size_t>(input)].unit; }

std::optional<Input> input_named(std::string_view name) {
  const auto match = std::ranges::find(rows, name, &Row::name);
  if (match == rows.end()) return std::nullopt;
  return static_cast<Input>(match - rows.begin());
}

const OutputModel* find_model_of(const std::vector<OutputModel>& models, std::string_view role) {
  const auto match = std::ranges::find(models, role, &OutputModel::role);
  return match == models.end() ? nullptr : &*match;
}

}  // namespace tumble
