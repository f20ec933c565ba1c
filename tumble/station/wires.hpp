#pragma once

#include <cstddef>
#include <functional>
#include <string_view>
#include <vector>

#include "tumble/station/link.hpp"

namespace tumble {

/// Functions that carry bytes between a station and its devices, and the clock of the station: real links, or a virtual
/// rig in simulated time. Wires have numbers: first the controllers of the station in their order, then its
/// instruments.
struct Wires {
  std::function<double()> now;  ///< [s]
  std::function<void(std::size_t wire, std::string_view bytes)> send;
  /// Events up to `until` [s] of that clock; returns as soon as there is one. The order is that of time.
  std::function<std::vector<LinkEvent>(double until)> wait;
};

}  // namespace tumble
