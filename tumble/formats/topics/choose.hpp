#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tumble/core/read_options.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/formats/topics/topic.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::topics {

/// Indices of the `count` topics [1] that were asked for, of which `meets(index, asked)` says whether one is meant.
/// Throws Error::bad_file with `refusal(asked)` for each that no topic meets.
std::vector<std::size_t> asked_for(std::size_t count, const std::vector<std::string>& topics,
                                   const std::function<bool(std::size_t, const std::string&)>& meets,
                                   const std::function<Problem(const std::string&)>& refusal);
/// Indices of the topics that were asked for: "IMU" means every instance, "IMU:1" one.
/// Throws Error::bad_file that names the topics there are where one that was asked for is not among them.
std::vector<std::size_t> asked_for(const std::vector<std::string>& names, const std::vector<std::string>& topics,
                                   const std::string& path);

/// A finding that names the topics that are not read; nothing where all are.
void name_the_others(const std::vector<std::string>& names, const std::vector<std::size_t>& chosen, Findings& findings);

/// Each column gets the first of its names that no other channel has.
void name_columns(std::vector<Topic>& topics);
/// Removes the columns that are not among `only`, unless it is empty, and then the topics without columns.
void keep_columns(const std::vector<std::string>& only, std::vector<Topic>& topics);
/// Gives a unit to the columns of which the file says none: that of `units`, by the name of the channel, else "1".
/// The names of the latter are returned.
std::vector<std::string> give_units(const std::map<std::string, Unit>& units, Topic& topic);

/// Names, units and kinds of the channels of `log`, by topic and column; removes the columns and topics that nobody
/// wants. A column without a unit has that of `options`, or is a plain number, which a finding says. Meta says where
/// each channel comes from. Throws Error::bad_file where nothing remains.
void name_channels(const ReadOptions& options, Log& log);

}  // namespace tumble::topics
