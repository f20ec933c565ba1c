#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <utility>

#include "tumble/station/carry_out.hpp"
#include "tumble/station/recorder_stream.hpp"

namespace tumble::conduct {

/// Recorder of the stream of an instrument; null: it has no stream. `several`: units are in the run.
std::unique_ptr<InstrumentRecorder> recorder_of(const StationInstrument& instrument, const StationParts::Stream& stream,
                                                bool several, Recorder& recorder, LiveEstimates* estimates);

/// Events of the store, of which others hear when they are on the disk.
class ToldEvents {
 public:
  ToldEvents(Recorder& recorder, const RunCompany& company) : recorder_(recorder), company_(company) {}

  /// Returned: its number; 0: the recording has stopped.
  std::uint64_t record(StoreEvent event);
  void tell();
  /// The number up to which all events were passed on, of those up to `on_disk`.
  std::uint64_t told(std::uint64_t on_disk) const;

 private:
  Recorder& recorder_;
  const RunCompany& company_;
  std::deque<std::pair<std::uint64_t, StoreEvent>> unheard_;  ///< on their way to the disk
};

/// Who watches does not end a run: a terminal may be closed, a log may be full.
void show_to_company(const std::function<void()>& show);

}  // namespace tumble::conduct
