#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/formats/topics/topic.hpp"

namespace tumble::ulog {

/// A topic of inertial samples that PX4 writes.
struct KnownTopic {
  std::string_view name;
  bool gyro, accelerometer;  ///< what it holds
  bool corrected;            ///< by the calibration of the autopilot
  bool burst;                ///< several samples a message
};

/// Null for all others.
const KnownTopic* known_topic(std::string_view name);

/// Names and unit of a field of a known topic; false for a field that is no sample. `instance`: of the topic.
bool describe(const KnownTopic& topic, int instance, topics::Column& column);

/// Topics that are read where the user names none: indices among `names`, which are "topic:instance", with `messages`
/// of each. Uncorrected topics; corrected ones only where a log has no others.
std::vector<std::size_t> preferred(const std::vector<std::string>& names, const std::vector<std::size_t>& messages);

/// "sensor_gyro:1" in its parts.
std::string base_of(const std::string& name);
int instance_of(const std::string& name);

}  // namespace tumble::ulog
