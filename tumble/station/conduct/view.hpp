#pragma once

#include <memory>
#include <vector>

#include "tumble/station/carry_out.hpp"
#include "tumble/station/executive.hpp"
#include "tumble/station/recorder_stream.hpp"

namespace tumble::conduct {

/// State of a run and of its streams as people see it.
///
/// Given     streams   by instrument; null: one without a stream
///           time      [s] since the beginning of the run
///           recorded  [s] since the present segment is recorded, where it is
RunView view_of(const ExecutiveState& state, const std::vector<std::unique_ptr<InstrumentRecorder>>& streams,
                double time, double recorded);

}  // namespace tumble::conduct
