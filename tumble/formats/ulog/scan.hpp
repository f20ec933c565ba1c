#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/formats/ulog/definitions.hpp"
#include "tumble/formats/ulog/messages.hpp"

namespace tumble::ulog {

/// Result of a pass through the file.
struct Scan {
  struct Topic {
    std::string name;    ///< "sensor_gyro:0"
    std::string format;  ///< "sensor_gyro"
    std::size_t messages = 0;
  };
  struct Dropouts {
    std::size_t count = 0;
    double total = 0.0;                       ///< [s]
    double longest = 0.0;                     ///< [s]
    double first_at = 0.0, longest_at = 0.0;  ///< [s] on the clock of the log
  };

  Definitions definitions;
  Subscriptions subscriptions;
  std::vector<Topic> topics;  ///< as subscribed
  std::map<std::string, std::string> information, parameters;
  std::vector<std::string> unreadable;  ///< formats that are missing, have no time or are described in two ways
  std::optional<std::int64_t> begun;    ///< [us] since 1970-01-01 UTC of the first sample, as the GPS receiver says
  Dropouts dropouts;
  Damage damage;
};

/// Throws Error::bad_file.
Scan scan(const std::string& path);

/// Takes the samples of a message; `topic`: index in Scan::topics.
using Take = std::function<void(std::size_t topic, const char* sample)>;

/// Hands out the samples in the order of the file, each to the topic that its id means at this place: an id may be
/// given to another topic later. Throws Error::bad_file.
void replay(const std::string& path, const Progress& progress, const Take& take);

}  // namespace tumble::ulog
