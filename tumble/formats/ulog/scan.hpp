#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tumble/formats/ulog/definitions.hpp"
#include "tumble/formats/ulog/messages.hpp"

namespace tumble::ulog {

/// What a pass through the file shows.
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
  std::vector<std::string> unreadable;  ///< topics whose format is missing or has no time
  Dropouts dropouts;
  Damage damage;
};

/// Throws Error::bad_file.
Scan scan(const std::string& path);

}  // namespace tumble::ulog
