#pragma once

#include <array>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/methods/dtg_centrifuge/sums.hpp"
#include "tumble/rigs/rig.hpp"

/// A gyro and a reference gyro on the table of a centrifuge: which samples belong to which level of which power-up.
namespace tumble::dtg_centrifuge {

/// What is recorded of the instruments.
enum Signal : std::size_t { gyro, gyro_y, reference };

/// The channels of one recording.
struct Channels {
  std::array<const Channel*, most_signals> signal{};  ///< null: not recorded
  const Channel* arm = nullptr;                       ///< both or none
  const Channel* table = nullptr;
};

/// One power-up of one plan and what its rig does then, without errors.
struct RigPowerUp {
  const Plan* plan = nullptr;
  RigRun run;
  Reference reference;
  std::vector<double> begins;  ///< [s] of each segment since power-on, and the end of the last
};

/// The samples of one segment of the schedule that are used.
struct Stretch {
  std::size_t recording = 0;
  std::size_t power_up = 0;  ///< counted over all recordings
  int run = 1;
  std::string label;
  std::size_t rig = 0;  ///< index in Test::rigs
  std::size_t segment = 0;
  double power_on = 0.0;                    ///< [s] recording's clock
  double begin = 0.0, end = 0.0;            ///< [s] the same
  double arm_rate = 0.0, table_rate = 0.0;  ///< [rad/s] as the plan says; 0 at rest
  double spin_up = 1.0;                     ///< +1: spin axis up, -1: down
};

struct Test {
  std::vector<Channels> channels;  ///< one a recording
  std::vector<RigPowerUp> rigs;
  std::vector<Stretch> levels;
  std::vector<Stretch> rests;  ///< the last at rest before the first level of each power-up that has one
  std::size_t power_ups = 0;
  bool encoders = false;  ///< in all recordings
  Findings findings;
};

/// Throws Error::bad_input, bad_data with all that plan and recordings lack.
Test test_of(const Evidence& evidence);

/// "run 2, spin 3"
std::string where_of(const Stretch& stretch);

}  // namespace tumble::dtg_centrifuge
