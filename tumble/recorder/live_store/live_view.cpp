#include "tumble/recorder/live_store/live_view.hpp"

#include <filesystem>

namespace tumble::live_store {

namespace {

constexpr std::size_t not_shown = static_cast<std::size_t>(-1);

}  // namespace

LiveView::LiveView(const std::string& folder)
    : samples_((std::filesystem::path(folder) / live_samples_name).string()) {}

void LiveView::add_stream(std::size_t number, const StoreStream& stream) {
  const std::lock_guard lock(mutex_);
  if (channels_.size() <= number) channels_.resize(number + 1);
  if (number == 0) samples_.fact("instrument", stream.name);
  for (const FrameChannel& channel : stream.channels) {
    const bool shown = !channel.increment || stream.rate > 0.0;
    channels_[number].push_back(
        shown ? samples_.add({channel.name, stream.slot, channel.unit, channel.increment ? stream.rate : 1.0})
              : not_shown);
  }
}

void LiveView::set(const std::string& name, const std::string& value) {
  if (name == "target") samples_.fact(name, value);
}

void LiveView::sample(std::size_t stream, const StoreSample& sample) {
  const std::lock_guard lock(mutex_);
  if (stream >= channels_.size()) return;
  const auto& channels = channels_[stream];
  for (std::size_t i = 0; i < channels.size() && i < sample.values.size(); ++i)
    if (channels[i] != not_shown) samples_.sample(channels[i], sample.time, sample.values[i]);
}

void LiveView::journal(double time, const RunRow& row) {
  if (row.kind == RunRow::Kind::records) samples_.begin_mark(row.label, row.run, time);
  if (row.kind == RunRow::Kind::pauses || row.kind == RunRow::Kind::segment_ends) samples_.end_mark(time);
}

}  // namespace tumble::live_store
