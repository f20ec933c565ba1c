#pragma once

#include <array>
#include <cstddef>

#include "tumble/core/channel.hpp"

namespace tumble::imu_ferraris {

/// The samples at one end of a part of a turn.
struct TurnEnd {
  double mean = 0.0, samples = 0.0;
  bool still = false;  ///< they scatter as white noise does: nothing moves, or it moves evenly
};

/// The first and the last twentieth of a part, and enough samples to judge it.
std::array<TurnEnd, 2> ends_of(const Channel& channel, std::size_t begin, std::size_t end);

/// The integral of an output over one part of a section.
struct Turned {
  double total = 0.0;     ///< [output s]
  double variance = 0.0;  ///< [output^2 s^2] by what may have happened where samples are missing
  double bridged = 0.0;   ///< [s] without samples
};

/// Each sample holds until the next one. Where samples are missing, in a gap of the stamps or one by one, the output goes on
/// in a straight line; what such a line is wrong by is tried on the parts of the same turn that have their samples.
///
/// Given     begin, end  indices of the samples of the part
///           from, to    [s] its marks; `to` infinite: it ends with its last sample
Turned turned_in(const Channel& channel, std::size_t begin, std::size_t end, double from, double to);

}  // namespace tumble::imu_ferraris
