#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/math/random.hpp"
#include "tumble/models/model.hpp"

namespace tumble {

/// One axis of a rig and how a plan may move it.
struct Axis {
  std::string name;
  std::string unit;  ///< of its position
  std::vector<Motion::Kind> motions;
  std::string description;
};

/// What the instrument truly felt in one run, evenly sampled, and what the rig's own sensors showed.
struct Reference {
  double start = 0.0;  ///< [s]
  double rate = 0.0;   ///< [Hz]
  std::vector<Felt> felt;
  std::vector<Channel> sensors;  ///< as recorded: lagged, quantised, noisy
};

/// A catalogue entry of rigs/: turns one run of a schedule into what the instrument feels.
struct Rig {
  const char* name;
  const char* summary;
  std::vector<Axis> (*axes)();
  std::vector<Option> (*options)();
  /// `run` holds the segments of one power-up; `begin` [s] is when it starts on the recording's clock. Every random
  /// number comes from `random`, so the same stream gives the same reference.
  Reference (*reference)(const Schedule& run, double begin, const Settings& options, const std::optional<Site>& site,
                         double sample_rate, const RandomStream& random);
  /// Everything in the schedule the rig cannot do, as messages; empty: it can.
  std::vector<std::string> (*refusals)(const Schedule& schedule, const Settings& options);
};

/// The entry of that name, or Error::unsupported with the nearest known name.
const Rig& find_rig(std::string_view name);

namespace rigs {
const std::vector<const Rig*>& catalogue();
}

}  // namespace tumble
