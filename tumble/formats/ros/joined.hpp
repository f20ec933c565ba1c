#pragma once

#include <string>
#include <vector>

#include "tumble/formats/ros/log.hpp"

namespace tumble::ros {

/// The files of one bag as one log: one behind the other. Given: path, of their folder; parts, at least one.
Log joined(const std::string& path, std::vector<Log> parts);

}  // namespace tumble::ros
