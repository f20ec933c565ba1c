#pragma once

#include <string>

#include "tumble/formats/ros/log.hpp"

namespace tumble::mcap {

/// A file with what it says of itself. Throws Error::bad_file.
ros::Log open(const std::string& path);

}  // namespace tumble::mcap
