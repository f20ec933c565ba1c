#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/formats/file/even_clock.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble::frames {

inline constexpr std::size_t stamps_for_rate = 1'000'000;  ///< of a group; its rate needs no more

/// Channels that the same frames carry, and their common clock.
struct Group {
  std::vector<std::size_t> channels;  ///< of the codec
  bool increments = false;            ///< some of them are increments
  file::EvenClock clock;
  std::vector<double> stamps;  ///< [s] as far as they are wanted
  std::size_t count = 0;       ///< samples
  std::optional<double> last;  ///< [s]

  /// Notes a sample at t [s]; `place` [s] is a step of the clock. The first `most` stamps are kept.
  void add(double t, double place, std::size_t most);
};

/// The channels of the codec that are wanted, in groups; empty `only`: all.
std::vector<Group> groups_of(const FrameCodec& codec, const std::vector<std::string>& only);

/// [Hz] at which a group is sampled while its clock runs; 0 where it does not show.
double rate_of(const Group& group);

/// [s] a step of the clock of the device, by layout; 0 where it has none.
std::vector<double> steps_of(const FrameCodec& codec);

}  // namespace tumble::frames
