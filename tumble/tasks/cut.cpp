#include "tumble/tasks/cut.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "tumble/core/marks.hpp"
#include "tumble/formats/conflicts.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {
namespace {

constexpr std::size_t samples_per_slice = 65536;

/// The samples of a channel that lie in the span.
Channel part_of(const Channel& channel, const TimeSpan& span) {
  Channel part{channel.name, channel.kind, channel.unit, channel.timeline, {}};
  std::size_t first = channel.values.size(), end = first;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    if (channel.time(i) < span.from || channel.time(i) > span.to) continue;
    first = std::min(first, i);
    end = i + 1;
  }
  part.values.assign(channel.values.begin() + static_cast<std::ptrdiff_t>(first),
                     channel.values.begin() + static_cast<std::ptrdiff_t>(end));
  if (channel.timeline.uniform()) {
    // Also of a block without samples of this channel: the next ones continue this clock.
    const double before = std::ceil((span.from - channel.timeline.start) * channel.timeline.rate);
    if (first < end)
      part.timeline.start = channel.time(first);
    else if (std::isfinite(before) && before > 0.0)
      part.timeline.start += before / channel.timeline.rate;
  } else {
    const auto& stamps = *channel.timeline.stamps;
    part.timeline.stamps = std::make_shared<const std::vector<double>>(
        stamps.begin() + static_cast<std::ptrdiff_t>(first), stamps.begin() + static_cast<std::ptrdiff_t>(end));
  }
  return part;
}

/// Channels of one clock still have one.
Recording part_of(const Recording& block, const TimeSpan& span) {
  Recording part{block.instrument, {}, {}, block.origin, block.meta, block.findings, block.recognised};
  for (const Channel& channel : block.channels) {
    part.channels.push_back(part_of(channel, span));
    for (std::size_t i = 0; i + 1 < part.channels.size() && !channel.timeline.uniform(); ++i)
      if (block.channels[i].timeline.stamps == channel.timeline.stamps)
        part.channels.back().timeline.stamps = part.channels[i].timeline.stamps;
  }
  for (std::size_t i = 0; i < block.marks.size(); ++i)
    if (block.marks[i].begin <= span.to && end_of_mark(block, i) > span.from) part.marks.push_back(block.marks[i]);
  return part;
}

bool is_empty(const Recording& part) {
  return std::ranges::all_of(part.channels, [](const Channel& channel) { return channel.values.empty(); });
}

/// Thrown to end the reading of a recording after its first block.
struct Seen {};

}  // namespace

void require_channels(const std::string& path, ReadOptions options) {
  const auto wanted = std::exchange(options.only, {});
  if (wanted.empty()) return;
  std::vector<std::string> names;
  try {
    stream_recording(format_of(path, options), path, options, samples_per_slice,
                     [&](const Recording& block) {
                       for (const Channel& channel : block.channels) names.push_back(channel.name);
                       throw Seen{};
                     },
                     {});
  } catch (const Seen&) {
  }
  Problems problems;
  for (const auto& name : wanted)
    if (std::ranges::find(names, name) == names.end())
      problems.push_back(say("'{}' has no channel '{}'{} (channels: {})", path, name, did_you_mean(name, names),
                             fmt::join(names, ", ")));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

void cut(const std::string& from, const std::string& to, const ReadOptions& options, const TimeSpan& span,
         const Progress& progress) {
  if (!(span.from < span.to)) throw Error(Error::Kind::bad_input, "--from must be before --to");
  const Format& source = format_of(from, options);
  const RecordingWriter writer = recording_writer(to);
  bool first = true, written = false;
  std::vector<Mark> marks;
  stream_recording(
      source, from, options, samples_per_slice,
      [&](const Recording& block) {
        if (std::exchange(first, false)) {
          refuse_conflicts(block, options);
          marks = part_of(block, span).marks;
        }
        Recording part = part_of(block, span);
        if (is_empty(part)) return;
        if (!std::exchange(written, true)) part.marks = marks;
        writer.append(part);
      },
      progress);
  if (!written)
    throw Error(Error::Kind::bad_data, say("'{}' has no sample from {:g} s to {:g} s", from, span.from, span.to));
  writer.commit();
}

}  // namespace tumble
