#pragma once

#include <vector>

#include "tumble/station/carry_out.hpp"
#include "tumble/station/conduct/instrument_line.hpp"
#include "tumble/station/executive.hpp"

namespace tumble::conduct {

/// State of a run and of its streams as people see it.
///
/// Given     time      [s] since the beginning of the run
///           recorded  [s] since the present segment is recorded, where it is
RunView view_of(const ExecutiveState& state, const std::vector<InstrumentLine>& instruments, double time,
                double recorded);

}  // namespace tumble::conduct
