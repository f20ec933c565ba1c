#include "tumble/station/conduct/recorders.hpp"

#include <algorithm>

#include "tumble/units/error.hpp"

namespace tumble::conduct {

std::unique_ptr<InstrumentRecorder> recorder_of(const StationInstrument& instrument, const StationParts::Stream& stream,
                                                bool several, Recorder& recorder, LiveEstimates* estimates) {
  if (instrument.frames.empty()) return nullptr;
  StoreLink link;
  link.name = instrument.link.empty() ? instrument.slot : instrument.link;
  link.slot = several ? instrument.slot : "";
  link.declaration = stream.text;
  link.declaration_name = stream.name;
  link.variants = stream.variants;
  return std::make_unique<InstrumentRecorder>(recorder, stream.codec, link, estimates);
}

void show_to_company(const std::function<void()>& show) {
  try {
    show();
  } catch (const Error&) {
  }
}

std::uint64_t ToldEvents::record(StoreEvent event) {
  const std::uint64_t sequence = recorder_.event(event);
  if (company_.event)
    unheard_.emplace_back(sequence, [this, sequence, event = std::move(event)] { company_.event(sequence, event); });
  return sequence;
}

std::uint64_t ToldEvents::record(double time, const RunRow& row) {
  const std::uint64_t sequence = recorder_.journal(time, row);
  if (company_.row) unheard_.emplace_back(sequence, [this, sequence, time, row] { company_.row(sequence, time, row); });
  return sequence;
}

void ToldEvents::tell() {
  if (unheard_.empty()) return;
  const std::uint64_t on_disk = recorder_.acknowledged().sequence;
  for (; !unheard_.empty() && unheard_.front().first <= on_disk; unheard_.pop_front())
    show_to_company(unheard_.front().second);
}

std::uint64_t ToldEvents::told(std::uint64_t on_disk) const {
  return unheard_.empty() ? on_disk : std::min(on_disk, unheard_.front().first - 1);
}

}  // namespace tumble::conduct
