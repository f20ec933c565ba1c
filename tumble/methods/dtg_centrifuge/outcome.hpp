#pragma once

#include <vector>

#include "tumble/methods/dtg_centrifuge/describe.hpp"
#include "tumble/methods/dtg_centrifuge/reference_line.hpp"

/// Levels, harmonics and lag of one output, fitted together.
namespace tumble::dtg_centrifuge {

/// A cell: one level in one sense in one plan, alike in every power-up.
struct Cells {
  std::vector<const Spin*> stretch;
  std::vector<RigLines> nominal;
  std::vector<std::size_t> of;  ///< of each measured
};

Cells cells_of(const Test& test, const std::vector<Measured>& measured, const Reduction& reduction);

/// The data that the reduction of one output starts from.
struct Task {
  const Test& test;
  const Reduction& reduction;
  const Cells& cells;
  const std::vector<RigLinesShift>& shifts;
  const Settings& settings;
  const Sensitivity& sensitivity;
  const ReferenceLine& line;  ///< of the reference
  bool late_alike;            ///< both gyros have the lag of that line
  Signal output;
  bool fourier, phase_known;

  bool loop_stated() const { return settings.has("natural_frequency") || settings.has("time_constant"); }
};

/// Whether the gyro under test has the lag of the reference gyro rather than none beyond that of a stated loop: then it is one of
/// the stamps, and the reference knows it best. Given: lines of which those of the reference are without its lag.
bool has_lag_of_reference(const Task& task, const std::vector<Measured>& measured);

/// Everything of one output. A lag that contradicts a stated loop is a finding, and is estimated with the rest.
Outcome outcome_of(const Task& task, const std::vector<Measured>& measured, Findings& findings);

}  // namespace tumble::dtg_centrifuge
