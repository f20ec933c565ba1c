#include "tumble/formats/ros/recording.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/ros/overview.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/room.hpp"

namespace tumble::ros {
namespace {

using Stretches = std::span<const Stretch* const>;

/// [ns] Memory that the analysis takes next.
using Times = std::vector<std::int64_t, RoomAllocator<std::int64_t>>;

/// All samples of a stream.
struct Gathered {
  Times stamps, received;
  std::vector<std::vector<double>> values;  ///< [SI]
  std::vector<std::size_t> infinite;        ///< of each column
};

/// Converts what was appended from `begin` on to SI; infinite numbers become missing samples, and are counted.
std::size_t to_si(const Unit& unit, std::vector<double>& values, std::size_t begin) {
  const double factor = unit.factor(), offset = unit.offset();
  double zero = 0.0;
  for (std::size_t i = begin; i < values.size(); ++i) {
    values[i] = values[i] * factor + offset;
    zero += values[i] * 0.0;
  }
  if (zero == 0.0) return 0;
  std::size_t infinite = 0;
  for (std::size_t i = begin; i < values.size(); ++i) {
    if (!std::isinf(values[i])) continue;
    values[i] = std::nan("");
    ++infinite;
  }
  return infinite;
}

template <class From, class To>
void append(const From& from, std::size_t count, To& to) {
  to.insert(to.end(), from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
}

void append_column(Stretches stretches, const std::vector<Stream>& streams, std::size_t stream, std::size_t column,
                   std::vector<Gathered>& all) {
  std::vector<double>& values = all[stream].values[column];
  const std::size_t begin = values.size();
  for (const Stretch* stretch : stretches) append((*stretch)[stream].values[column], (*stretch)[stream].count, values);
  all[stream].infinite[column] += to_si(streams[stream].columns[column].unit, values, begin);
}

void append_stamps(Stretches stretches, std::size_t stream, Gathered& all) {
  for (const Stretch* stretch : stretches) {
    append((*stretch)[stream].stamps, (*stretch)[stream].count, all.stamps);
    append((*stretch)[stream].received, (*stretch)[stream].count, all.received);
  }
}

/// What is small, in the order of the file.
void note(Stretches stretches, std::vector<Overview>& overviews) {
  for (const Stretch* stretch : stretches)
    for (std::size_t s = 0; s < overviews.size(); ++s) {
      const Samples& samples = (*stretch)[s];
      Overview& overview = overviews[s];
      overview.unreadable += samples.unreadable;
      for (const std::string* const frame : {&samples.frame, &samples.other_frame}) {
        if (overview.frame.empty()) overview.frame = *frame;
        if (overview.other_frame.empty() && *frame != overview.frame) overview.other_frame = *frame;
      }
      for (std::size_t i = 0; i < overview.measured.size(); ++i) overview.measured[i] |= samples.measured[i];
    }
}

std::vector<Overview> overviews_of(const std::vector<Stream>& streams) {
  std::vector<Overview> overviews(streams.size());
  for (std::size_t s = 0; s < streams.size(); ++s) overviews[s].measured.assign(streams[s].columns.size(), 0);
  return overviews;
}

/// At most so many messages of a stream: as the index says, and as the file has room for.
std::size_t most_messages(const Log& log, const Stream& stream) {
  const std::uint64_t message = 8 * stream.type->numbers + 12;
  const std::uint64_t known = log.messages_at_most > 0 ? log.messages_at_most : stream.topic.count.messages;
  std::uint64_t bytes = size_of(log);
  for (const Piece& piece : log.pieces)
    if (piece.packing != Packing::none) bytes += std::min(piece.unpacked, piece.size * 256);
  return std::min(known, bytes / message);
}

/// A vector that samples are appended to: a column, or after the last the stamps.
struct Destination {
  std::size_t stream, column;
};

std::vector<Gathered> gather(const Log& log, const std::vector<Stream>& streams, std::vector<Overview>& overviews,
                             ScanReport& report, const Progress& progress) {
  std::vector<Gathered> all(streams.size());
  std::vector<Destination> parts;
  for (std::size_t s = 0; s < streams.size(); ++s) {
    const std::size_t count = most_messages(log, streams[s]);
    all[s].values.resize(streams[s].columns.size());
    all[s].infinite.resize(streams[s].columns.size());
    all[s].stamps.reserve(count);
    all[s].received.reserve(count);
    for (std::size_t c = 0; c < streams[s].columns.size(); ++c) {
      make_room(all[s].values[c], count);
      parts.push_back({s, c});
    }
    parts.push_back({s, streams[s].columns.size()});
  }
  report = scan(
      log, streams,
      [&](Stretches stretches) {
        note(stretches, overviews);
        parallel_for(parts.size(), [&](std::size_t p) {
          const auto [stream, column] = parts[p];
          if (column == streams[stream].columns.size())
            append_stamps(stretches, stream, all[stream]);
          else
            append_column(stretches, streams, stream, column, all);
        });
      },
      progress);
  return all;
}

template <class Values>
void rearrange(const std::vector<std::size_t>& order, Values& values) {
  Values sorted;
  sorted.reserve(values.size());
  for (const std::size_t i : order) sorted.push_back(values[i]);
  values = std::move(sorted);
}

/// Whether this order mixes stretches that lie far apart in the file, message by message: their clock was set back
/// between them, while a late message or a chunk in another place stays together.
bool mixes(const std::vector<std::size_t>& order, std::size_t backward) {
  constexpr std::size_t near = 64, often = 4;
  std::size_t jumps = 0;
  for (std::size_t i = 1; i < order.size(); ++i)
    jumps += std::max(order[i], order[i - 1]) - std::min(order[i], order[i - 1]) > near;
  return jumps > often * (backward + 1);
}

/// In the order in which they were received. False where that would mix them: then they are as before.
bool sort_by_time(Gathered& all, std::size_t backward) {
  std::vector<std::size_t> order(all.received.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return all.received[i]; });
  if (mixes(order, backward)) return false;
  rearrange(order, all.stamps);
  rearrange(order, all.received);
  for (auto& column : all.values) rearrange(order, column);
  return true;
}

ClockSummary summary_of(const Gathered& all) {
  ClockSummary clocks;
  for (std::size_t i = 0; i < all.stamps.size(); ++i) clocks.add(all.stamps[i], all.received[i]);
  return clocks;
}

/// The chosen clock of a stream that is in memory. What is left in `all.stamps` are its times [ns].
void settle_clock(const Stream& stream, std::optional<double> rate, Gathered& all, Overview& overview,
                  Findings& findings) {
  overview.clocks = summary_of(all);
  if (overview.clocks.out_of_order() && sort_by_time(all, overview.clocks.backward)) {
    overview.sorted = overview.clocks.backward;
    overview.clocks = summary_of(all);
  }
  overview.choice = choose_clock(overview.clocks, stream.topic.name, findings);
  overview.first = overview.choice.time(overview.clocks.first_stamp, overview.clocks.first_received);
  file::EvenClock clock;
  for (std::size_t i = 0; i < all.stamps.size(); ++i) {
    all.stamps[i] = overview.choice.time(all.stamps[i], all.received[i]);
    clock.add(seconds_after(overview.first, all.stamps[i]), 1e-9);
  }
  overview.even = clock.timeline(rate);
  for (const std::size_t infinite : all.infinite) overview.infinite += infinite;
}

std::shared_ptr<const std::vector<double>> stamps_of(std::span<const std::int64_t> times, std::int64_t epoch) {
  std::vector<double> stamps(times.size());
  std::ranges::transform(times, stamps.begin(), [&](std::int64_t time) { return seconds_after(epoch, time); });
  return std::make_shared<const std::vector<double>>(std::move(stamps));
}

/// Hands the samples of the columns that are channels to them, in their order.
template <class Give>
void each_channel(const std::vector<Stream>& streams, const std::vector<Overview>& overviews, Recording& recording,
                  Give give) {
  std::size_t next = 0;
  for (std::size_t s = 0; s < streams.size(); ++s)
    for (std::size_t c = 0; c < streams[s].columns.size(); ++c)
      if (overviews[s].clocks.count > 0 && overviews[s].measured[c]) give(s, c, recording.channels[next++]);
}

}  // namespace

Recording read(Log log, const ReadOptions& options, const Progress& progress) {
  auto checksum = checksum_of(log);
  look_into_uncounted(log);
  const auto streams = choose_streams(log, options);
  auto overviews = overviews_of(streams);
  ScanReport report;
  auto all = gather(log, streams, overviews, report, progress);
  Findings clock_findings;
  for (std::size_t s = 0; s < streams.size(); ++s)
    settle_clock(streams[s], options.rate, all[s], overviews[s], clock_findings);
  Recording recording = frame_of(log, streams, overviews, report, clock_findings);
  recording.origin.checksum = std::move(checksum);
  const std::int64_t epoch = epoch_of(overviews);
  std::vector<std::shared_ptr<const std::vector<double>>> stamps(streams.size());
  each_channel(streams, overviews, recording, [&](std::size_t s, std::size_t c, Channel& channel) {
    channel.values = std::move(all[s].values[c]);
    if (overviews[s].even) return;
    if (!stamps[s]) stamps[s] = stamps_of(all[s].stamps, epoch);
    channel.timeline = {0.0, 0.0, stamps[s]};
  });
  return recording;
}

std::uintmax_t memory(Log log, const ReadOptions& options) {
  look_into_uncounted(log);
  std::uintmax_t bytes = 0;
  for (const Stream& stream : choose_streams(log, options))
    bytes += sizeof(double) * (stream.columns.size() + 2) * most_messages(log, stream);
  return bytes;
}

namespace {

/// The two clocks of a stream that is only seen once.
struct BothClocks {
  file::EvenClock header, recorder;
};

/// A first pass over the file: what is known before the first block is handed out.
std::vector<Overview> look_over(const Log& log, const std::vector<Stream>& streams, std::optional<double> rate,
                                ScanReport& report, Findings& findings) {
  auto overviews = overviews_of(streams);
  std::vector<BothClocks> clocks(streams.size());
  const auto take = [&](Stretches stretches) {
    note(stretches, overviews);
    for (const Stretch* stretch : stretches)
      for (std::size_t s = 0; s < streams.size(); ++s) {
        const Samples& samples = (*stretch)[s];
        ClockSummary& summary = overviews[s].clocks;
        for (std::size_t i = 0; i < samples.count; ++i) {
          summary.add(samples.stamps[i], samples.received[i]);
          clocks[s].header.add(seconds_after(summary.first_stamp, samples.stamps[i]), 1e-9);
          clocks[s].recorder.add(seconds_after(summary.first_received, samples.received[i]), 1e-9);
        }
        for (const auto& column : samples.values)
          overviews[s].infinite += static_cast<std::size_t>(
              std::count_if(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(samples.count),
                            [](double value) { return std::isinf(value); }));
      }
  };
  report = scan(log, streams, take, {});
  for (std::size_t s = 0; s < streams.size(); ++s) {
    Overview& overview = overviews[s];
    overview.choice = choose_clock(overview.clocks, streams[s].topic.name, findings);
    overview.first = overview.choice.time(overview.clocks.first_stamp, overview.clocks.first_received);
    overview.even = (overview.choice.header ? clocks[s].header : clocks[s].recorder).timeline(rate);
  }
  return overviews;
}

/// Samples that wait to be handed out as a block.
class Blocks {
 public:
  Blocks(const std::vector<Stream>& streams, const std::vector<Overview>& overviews, Recording frame,
         std::size_t samples, const BlockSink& sink)
      : streams_(streams),
        overviews_(overviews),
        block_(std::move(frame)),
        samples_(samples),
        sink_(sink),
        epoch_(epoch_of(overviews)),
        times_(streams.size()),
        sent_(streams.size(), 0) {}

  void take(Stretches stretches) {
    for (const Stretch* stretch : stretches) {
      each_channel(streams_, overviews_, block_, [&](std::size_t s, std::size_t c, Channel& channel) {
        const std::size_t begin = channel.values.size();
        append((*stretch)[s].values[c], (*stretch)[s].count, channel.values);
        to_si(streams_[s].columns[c].unit, channel.values, begin);
      });
      std::size_t longest = 0;
      for (std::size_t s = 0; s < streams_.size(); ++s) {
        const Samples& samples = (*stretch)[s];
        for (std::size_t i = 0; i < samples.count; ++i)
          times_[s].push_back(overviews_[s].choice.time(samples.stamps[i], samples.received[i]));
        longest = std::max(longest, times_[s].size());
      }
      if (longest >= samples_) send();
    }
  }

  void send() {
    if (std::ranges::all_of(times_, [](const auto& times) { return times.empty(); })) return;
    std::vector<std::shared_ptr<const std::vector<double>>> stamps(streams_.size());
    each_channel(streams_, overviews_, block_, [&](std::size_t s, std::size_t, Channel& channel) {
      const auto& even = overviews_[s].even;
      if (!even && !stamps[s]) stamps[s] = stamps_of(times_[s], epoch_);
      if (even)
        channel.timeline = {seconds_after(epoch_, overviews_[s].first) + static_cast<double>(sent_[s]) / even->rate,
                            even->rate, nullptr};
      else
        channel.timeline = {0.0, 0.0, stamps[s]};
    });
    sink_(block_);
    block_.findings.clear();  // are said once
    for (std::size_t s = 0; s < streams_.size(); ++s) {
      sent_[s] += times_[s].size();
      times_[s].clear();
    }
    for (Channel& channel : block_.channels) channel.values.clear();
  }

 private:
  const std::vector<Stream>& streams_;
  const std::vector<Overview>& overviews_;
  Recording block_;
  std::size_t samples_;
  const BlockSink& sink_;
  std::int64_t epoch_;
  std::vector<std::vector<std::int64_t>> times_;  ///< [ns]
  std::vector<std::size_t> sent_;
};

}  // namespace

void stream(Log log, const ReadOptions& options, std::size_t samples, const BlockSink& sink, const Progress& progress) {
  look_into_uncounted(log);
  const auto streams = choose_streams(log, options);
  ScanReport report;
  Findings clock_findings;
  const auto overviews = look_over(log, streams, options.rate, report, clock_findings);
  // Messages that are not in order have to be sorted, and for that all of them must be there.
  if (std::ranges::any_of(overviews, [](const Overview& overview) { return overview.clocks.out_of_order(); }))
    return hand_out(read(std::move(log), options, progress), samples, sink);
  Recording frame = frame_of(log, streams, overviews, report, clock_findings);
  Blocks blocks(streams, overviews, std::move(frame), samples, sink);
  scan(
      log, streams, [&](Stretches stretches) { blocks.take(stretches); }, progress);
  blocks.send();
}

}  // namespace tumble::ros
