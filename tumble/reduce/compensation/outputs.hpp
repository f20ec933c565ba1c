#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/models/model.hpp"
#include "tumble/units/sentence.hpp"

/// Work that a compensation does for each output, with a model of any form: it finds its channels, takes terms and
/// covariance from the result, and writes beside each output how far it can be trusted.
namespace tumble::compensation {

/// Whether the channel of an output can be compensated. Where the channel is null, or it is compensated already, this
/// goes to `problems`.
bool usable_output(const Channel* channel, const Recording& recording, const std::string& role, Problems& problems);

/// Adds a problem where a channel is there and its dimension is not that of `unit`.
void require_dimension(const Channel* channel, const std::string& unit, Problems& problems);

/// A number [SI] of a result's table. Throws Error::bad_file where the cell holds text.
double number_in(const Table& table, const Table::Cell& cell);

/// Throws    Error::bad_data with all problems, each with the recording's file before it, where there are any
void refuse(const Recording& recording, Problems problems);

/// Channels that are written beside a compensated output: how far it can be trusted.
struct Trust {
  Channel sd;            ///< <channel>.compensation_sd [as the output]: standard uncertainty of what was subtracted
  Channel extrapolated;  ///< <channel>.extrapolated: 1 where the calibration does not cover what was felt, else 0
};
/// Both channels as copies of the output, to be filled in.
Trust trust_in(const Channel& output);

}  // namespace tumble::compensation
