#include "tumble/formats/dataflash/known.hpp"

#include <algorithm>

namespace tumble::dataflash {
namespace {

/// The last three forms without an instance are those of older firmware.
constexpr KnownMessage known_messages[] = {{"GYR", true, false, 0},  {"ACC", false, true, 0},  {"IMU", true, true, 0},
                                           {"GYR1", true, false, 0}, {"GYR2", true, false, 1}, {"GYR3", true, false, 2},
                                           {"ACC1", false, true, 0}, {"ACC2", false, true, 1}, {"ACC3", false, true, 2},
                                           {"IMU2", true, true, 1},  {"IMU3", true, true, 2}};

struct Row {
  std::string_view label;
  const char *sensor, *axis, *unit;
};

constexpr Row rows[] = {{"GyrX", "gyro", ".x", "rad/s"},          {"GyrY", "gyro", ".y", "rad/s"},
                        {"GyrZ", "gyro", ".z", "rad/s"},          {"AccX", "accelerometer", ".x", "m/s^2"},
                        {"AccY", "accelerometer", ".y", "m/s^2"}, {"AccZ", "accelerometer", ".z", "m/s^2"},
                        {"T", "temperature", "", "degC"},         {"Temp", "temperature", "", "degC"}};

}  // namespace

const KnownMessage* known_message(std::string_view name) {
  const auto found = std::ranges::find(known_messages, name, &KnownMessage::name);
  return found == std::end(known_messages) ? nullptr : found;
}

bool describe(int instance, topics::Column& column) {
  const auto row = std::ranges::find(rows, column.field, &Row::label);
  if (row == std::end(rows)) return false;
  const std::string sensor = row->sensor, axis = row->axis;
  column.names = {sensor + axis, sensor + std::to_string(instance) + axis};
  if (!column.unit) column.unit = Unit::parse(row->unit);
  return true;
}

int instance_of(const Stream& stream, std::string_view name) {
  if (stream.instance >= 0) return stream.instance;
  const KnownMessage* const known = known_message(name);
  return known ? known->instance : 0;
}

std::vector<std::size_t> preferred(const Scan& scan, const std::vector<std::size_t>& streams) {
  std::vector<std::size_t> chosen;
  for (const auto quantity : {&KnownMessage::gyro, &KnownMessage::accelerometer}) {
    const Stream* best = nullptr;
    std::size_t index = 0;
    int lowest = 256;
    for (std::size_t i = 0; i < streams.size(); ++i) {
      const Stream& stream = scan.streams[streams[i]];
      const std::string& name = scan.descriptions[stream.id].name;
      const KnownMessage* const known = known_message(name);
      if (!known || !(known->*quantity)) continue;
      const int instance = instance_of(stream, name);
      if (best && (instance > lowest || (instance == lowest && stream.messages <= best->messages))) continue;
      best = &stream;
      lowest = instance;
      index = i;
    }
    if (best && std::ranges::find(chosen, index) == chosen.end()) chosen.push_back(index);
  }
  return chosen;
}

std::vector<std::string> corrections(const Scan& scan, const KnownMessage& message, int instance) {
  const std::string number = instance == 0 ? "" : std::to_string(instance + 1);
  std::vector<std::string> names;
  const auto take = [&](const std::string& name, double neutral) {
    const auto found = scan.parameters.find(name);
    if (found != scan.parameters.end() && found->second != neutral) names.push_back(name);
  };
  for (const char* axis : {"_X", "_Y", "_Z"}) {
    if (message.gyro) take("INS_GYR" + number + "OFFS" + axis, 0.0);
    if (message.gyro && instance == 0) take(std::string("INS_GYROFFS") + axis, 0.0);
    if (message.accelerometer) take("INS_ACC" + number + "OFFS" + axis, 0.0);
    if (message.accelerometer) take("INS_ACC" + number + "SCAL" + axis, 1.0);
  }
  take("INS_TCAL" + std::to_string(instance + 1) + "_ENABLE", 0.0);
  return names;
}

}  // namespace tumble::dataflash
