#pragma once

#include <array>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/methods/dtg_centrifuge/sums.hpp"
#include "tumble/reduce/stretches.hpp"

/// A gyro and a reference gyro on the table of a centrifuge: which samples belong to which level of which power-up.
namespace tumble::dtg_centrifuge {

/// Recorded signals of the instruments.
enum Signal : std::size_t { gyro, gyro_y, reference };

/// The channels of one recording.
struct Channels {
  std::array<const Channel*, most_signals> signal{};  ///< null: not recorded
  std::array<double, most_signals> step{};            ///< [s] of the clock of each: lost samples do not change it
  const Channel* arm = nullptr;                       ///< both or none
  const Channel* table = nullptr;
  double arm_step = 0.0, table_step = 0.0;  ///< [s] of their clocks
};

/// Whether two channels are sampled at the same times.
bool one_clock(const Channel& a, const Channel& b);

/// The samples of one segment of the schedule that are used.
struct Spin {
  std::size_t recording = 0;
  std::size_t start = 0;  ///< see MarkedSegment
  int run = 1;
  std::string label;
  std::size_t power_up = 0;  ///< index in Test::power_ups
  std::size_t segment = 0;
  double power_on = 0.0;                    ///< [s] recording's clock
  double begin = 0.0, end = 0.0;            ///< [s] recording's clock
  double arm_rate = 0.0, table_rate = 0.0;  ///< [rad/s] as the plan says; 0 at rest
  double spin_up = 1.0;                     ///< +1: spin axis up, -1: down
};

struct Test {
  std::vector<Channels> channels;  ///< one a recording
  std::vector<PowerUp> power_ups;
  std::vector<Spin> levels;
  std::vector<Spin> planned;  ///< levels of the plans' schedules in the runs that were recorded, recorded or not
  std::vector<Spin> rests;    ///< the last at rest before the first level of each start that has one
  std::size_t starts = 0;
  bool encoders = false;  ///< in all recordings
  Findings findings;
};

/// The test as carried out. Throws Error::bad_input, bad_data with everything that plan and recordings lack.
Test test_of(const Evidence& evidence);

/// "run 2, spin 3"
std::string where_of(const Spin& spin);

}  // namespace tumble::dtg_centrifuge
