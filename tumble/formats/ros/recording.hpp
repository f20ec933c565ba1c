#pragma once

#include "tumble/core/read_options.hpp"
#include "tumble/formats/ros/log.hpp"
#include "tumble/formats/topics/topic.hpp"

namespace tumble::ros {

/// The topics of an opened file that are wanted, for tumble::topics to read. With `checksum` another thread works out
/// that of the file meanwhile. Throws Error::bad_file, see choose_streams().
topics::Log topics_log(Log log, const ReadOptions& options, bool checksum);

}  // namespace tumble::ros
