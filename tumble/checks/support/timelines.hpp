#pragma once

#include <string>
#include <vector>

#include "tumble/core/recording.hpp"

namespace tumble::support {

/// Stamps that several channels may share, so that a fault of them is reported once.
struct StampedTimeline {
  const Channel* channel;  ///< the first that has them
  std::string where;       ///< its channels by name, or empty when all have them
};

/// The different stamped timelines of a recording; evenly sampled channels have none.
std::vector<StampedTimeline> stamped_timelines(const Recording& recording);

}  // namespace tumble::support
