// What a format that only reads whole files does not say itself: the memory that a recording takes, and its blocks.

#include <algorithm>
#include <map>

#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/shares.hpp"
#include "tumble/formats/format.hpp"

namespace tumble {
namespace {

using Stamps = std::shared_ptr<const std::vector<double>>;

/// Everything but the samples and the checksum, as a stream hands it out.
Recording frame_of(const Recording& whole) {
  Recording frame{whole.instrument, {}, whole.marks, {whole.origin.file}, whole.meta, whole.findings, whole.recognised};
  for (const Channel& channel : whole.channels)
    frame.channels.push_back({channel.name, channel.kind, channel.unit, channel.timeline, {}});
  return frame;
}

/// The times of samples `first` to `last`; channels that share their stamps in the whole share those of the block.
Timeline part_of(const Timeline& whole, std::size_t first, std::size_t last, std::map<Stamps, Stamps>& shared) {
  if (whole.uniform()) return {whole.time(first), whole.rate, nullptr};
  Stamps& stamps = shared[whole.stamps];
  if (!stamps)
    stamps = std::make_shared<const std::vector<double>>(whole.stamps->begin() + static_cast<std::ptrdiff_t>(first),
                                                         whole.stamps->begin() + static_cast<std::ptrdiff_t>(last));
  return {0.0, 0.0, stamps};
}

}  // namespace

void hand_out(const Recording& whole, std::size_t samples, const BlockSink& sink) {
  Recording block = frame_of(whole);
  std::size_t longest = 0;
  for (const Channel& channel : whole.channels) longest = std::max(longest, channel.values.size());
  const file::Shares shares(longest, samples);
  for (std::size_t index = 0; index < shares.blocks(); ++index) {
    std::map<Stamps, Stamps> shared;
    for (std::size_t i = 0; i < whole.channels.size(); ++i) {
      const Channel& channel = whole.channels[i];
      const std::size_t count = channel.values.size();
      const std::size_t first = shares.first(count, index), last = shares.first(count, index + 1);
      block.channels[i].timeline = part_of(channel.timeline, first, last, shared);
      block.channels[i].values.assign(channel.values.begin() + static_cast<std::ptrdiff_t>(first),
                                      channel.values.begin() + static_cast<std::ptrdiff_t>(last));
    }
    sink(block);
    block.findings.clear();
  }
}

std::uintmax_t recording_memory(const Format& format, const std::string& path, const ReadOptions& options) {
  return format.memory ? format.memory(path, options) : file::InputFile(path).size();
}

void stream_recording(const Format& format, const std::string& path, const ReadOptions& options, std::size_t samples,
                      const BlockSink& sink, const Progress& progress) {
  if (format.stream) return format.stream(path, options, samples, sink, progress);
  hand_out(format.read(path, options, progress), samples, sink);
}

}  // namespace tumble
