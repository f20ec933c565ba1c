#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/read_options.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/formats/topics/topic.hpp"

namespace tumble::topics {

/// Indices of the topics that were asked for: "IMU" means every instance, "IMU:1" one.
/// Throws Error::bad_file that names the topics there are where one that was asked for is not among them.
std::vector<std::size_t> asked_for(const std::vector<std::string>& names, const std::vector<std::string>& topics,
                                   const std::string& path);

/// A finding that names the topics that are not read; nothing where all are.
void name_the_others(const std::vector<std::string>& names, const std::vector<std::size_t>& chosen, Findings& findings);

/// Names, units and kinds of the channels of `log`, by topic and column; removes the columns and topics that nobody
/// wants. A column without a unit has that of `options`, or is a plain number, which a finding says. Meta says where
/// each channel comes from. Throws Error::bad_file where nothing remains.
void name_channels(const ReadOptions& options, Log& log);

}  // namespace tumble::topics
