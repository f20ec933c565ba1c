#include "tumble/formats/ulog/known.hpp"

#include <algorithm>
#include <cstdlib>

namespace tumble::ulog {
namespace {

/// In order of preference where two have as many samples.
constexpr KnownTopic known_topics[] = {{"sensor_gyro", true, false, false, false},
                                       {"sensor_gyro_fifo", true, false, false, true},
                                       {"sensor_accel", false, true, false, false},
                                       {"sensor_accel_fifo", false, true, false, true},
                                       {"sensor_combined", true, true, true, false},
                                       {"vehicle_imu", true, true, true, false},
                                       {"vehicle_angular_velocity", true, false, true, false},
                                       {"vehicle_acceleration", false, true, true, false}};

struct Row {
  std::string_view topic, field;
  const char* quantity;  ///< "gyro.x"
  const char* unit;
};

constexpr Row rows[] = {{"sensor_gyro", "x", "gyro.x", "rad/s"},
                        {"sensor_gyro", "y", "gyro.y", "rad/s"},
                        {"sensor_gyro", "z", "gyro.z", "rad/s"},
                        {"sensor_gyro", "temperature", "temperature.gyro", "degC"},
                        {"sensor_gyro_fifo", "x", "gyro.x", "rad/s"},
                        {"sensor_gyro_fifo", "y", "gyro.y", "rad/s"},
                        {"sensor_gyro_fifo", "z", "gyro.z", "rad/s"},
                        {"sensor_accel", "x", "accelerometer.x", "m/s^2"},
                        {"sensor_accel", "y", "accelerometer.y", "m/s^2"},
                        {"sensor_accel", "z", "accelerometer.z", "m/s^2"},
                        {"sensor_accel", "temperature", "temperature.accelerometer", "degC"},
                        {"sensor_accel_fifo", "x", "accelerometer.x", "m/s^2"},
                        {"sensor_accel_fifo", "y", "accelerometer.y", "m/s^2"},
                        {"sensor_accel_fifo", "z", "accelerometer.z", "m/s^2"},
                        {"sensor_combined", "gyro_rad.0", "gyro.x", "rad/s"},
                        {"sensor_combined", "gyro_rad.1", "gyro.y", "rad/s"},
                        {"sensor_combined", "gyro_rad.2", "gyro.z", "rad/s"},
                        {"sensor_combined", "accelerometer_m_s2.0", "accelerometer.x", "m/s^2"},
                        {"sensor_combined", "accelerometer_m_s2.1", "accelerometer.y", "m/s^2"},
                        {"sensor_combined", "accelerometer_m_s2.2", "accelerometer.z", "m/s^2"},
                        {"vehicle_imu", "delta_angle.0", "gyro.x", "rad"},
                        {"vehicle_imu", "delta_angle.1", "gyro.y", "rad"},
                        {"vehicle_imu", "delta_angle.2", "gyro.z", "rad"},
                        {"vehicle_imu", "delta_velocity.0", "accelerometer.x", "m/s"},
                        {"vehicle_imu", "delta_velocity.1", "accelerometer.y", "m/s"},
                        {"vehicle_imu", "delta_velocity.2", "accelerometer.z", "m/s"},
                        {"vehicle_angular_velocity", "xyz.0", "gyro.x", "rad/s"},
                        {"vehicle_angular_velocity", "xyz.1", "gyro.y", "rad/s"},
                        {"vehicle_angular_velocity", "xyz.2", "gyro.z", "rad/s"},
                        {"vehicle_acceleration", "xyz.0", "accelerometer.x", "m/s^2"},
                        {"vehicle_acceleration", "xyz.1", "accelerometer.y", "m/s^2"},
                        {"vehicle_acceleration", "xyz.2", "accelerometer.z", "m/s^2"}};

constexpr std::size_t samples_of_burst = 8;  ///< about: a message of a burst has from 4 to 32
constexpr std::size_t none = static_cast<std::size_t>(-1);

}  // namespace

const KnownTopic* known_topic(std::string_view name) {
  const auto found = std::ranges::find(known_topics, name, &KnownTopic::name);
  return found == std::end(known_topics) ? nullptr : found;
}

bool describe(const KnownTopic& topic, int instance, topics::Column& column) {
  const auto row =
      std::ranges::find_if(rows, [&](const Row& r) { return r.topic == topic.name && r.field == column.field; });
  if (row == std::end(rows)) return false;
  const std::string quantity = row->quantity;
  const auto dot = quantity.find('.');
  const std::string number = std::to_string(instance);
  if (column.field == "temperature")
    column.names = {"temperature", quantity, quantity + number};
  else
    column.names = {quantity, quantity.substr(0, dot) + number + quantity.substr(dot)};
  column.unit = Unit::parse(row->unit);
  return true;
}

std::string base_of(const std::string& name) { return name.substr(0, name.rfind(':')); }

int instance_of(const std::string& name) { return std::atoi(name.c_str() + name.rfind(':') + 1); }

std::vector<std::size_t> preferred(const std::vector<std::string>& names, const std::vector<std::size_t>& messages) {
  // Of each known topic the first instance; of those that hold one quantity, the one with the most samples.
  const auto best = [&](bool KnownTopic::*quantity, bool corrected) {
    std::size_t chosen = none, most = 0;
    for (const KnownTopic& known : known_topics) {
      if (!(known.*quantity) || known.corrected != corrected) continue;
      std::size_t first = none;
      for (std::size_t i = 0; i < names.size(); ++i)
        if (base_of(names[i]) == known.name && (first == none || instance_of(names[i]) < instance_of(names[first])))
          first = i;
      if (first == none) continue;
      const std::size_t samples = messages[first] * (known.burst ? samples_of_burst : 1);
      if (samples > most) {
        most = samples;
        chosen = first;
      }
    }
    return chosen;
  };
  std::vector<std::size_t> chosen;
  for (const bool corrected : {false, true}) {
    for (const auto quantity : {&KnownTopic::gyro, &KnownTopic::accelerometer})
      if (const std::size_t i = best(quantity, corrected); i != none && std::ranges::find(chosen, i) == chosen.end())
        chosen.push_back(i);
    if (!chosen.empty()) break;
  }
  return chosen;
}

}  // namespace tumble::ulog
