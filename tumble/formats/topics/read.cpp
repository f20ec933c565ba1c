#include "tumble/formats/topics/read.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/formats/file/even_clock.hpp"
#include "tumble/formats/topics/overview.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/room.hpp"

namespace tumble::topics {
namespace {

using Stretches = std::span<const Stretch* const>;
using Seconds = std::shared_ptr<const std::vector<double>>;

/// [ns] Memory that the analysis takes next.
using Times = std::vector<std::int64_t, RoomAllocator<std::int64_t>>;

constexpr double microsecond = 1e-6, nanosecond = 1e-9;  ///< [s] last digits of the stamps of one clock, and of two

/// A stretch of a log that is read by one thread: it stays in the cache until it is appended.
constexpr std::size_t samples_at_once = 2048;
constexpr std::size_t few_samples = 32768;  ///< fewer are appended before other threads have begun

/// All samples of a topic.
struct Gathered {
  std::vector<double> seconds;
  Times stamps, received;
  std::vector<std::vector<double>> values;  ///< [SI]
  std::vector<std::size_t> infinite;        ///< of each column
};

/// Converts what was appended from `begin` on to SI; infinite numbers become missing samples, and are counted.
std::size_t to_si(const Column& column, std::vector<double>& values, std::size_t begin) {
  const double factor = column.scale * column.unit->factor(), offset = column.unit->offset();
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

/// Number of infinite values that were appended.
std::size_t append_values(Stretches stretches, const Column& column, std::size_t topic, std::size_t index,
                          std::vector<double>& to) {
  const std::size_t begin = to.size();
  for (const Stretch* stretch : stretches) append((*stretch)[topic].values[index], (*stretch)[topic].count, to);
  return to_si(column, to, begin);
}

void append_stamps(Stretches stretches, std::size_t topic, bool two_clocks, Gathered& to) {
  for (const Stretch* stretch : stretches) {
    const Samples& samples = (*stretch)[topic];
    if (two_clocks) {
      append(samples.stamps, samples.count, to.stamps);
      append(samples.received, samples.count, to.received);
    } else {
      append(samples.seconds, samples.count, to.seconds);
    }
  }
}

Gathered gathered_of(const Topic& topic, bool two_clocks) {
  Gathered all;
  all.values.resize(topic.columns.size());
  all.infinite.resize(topic.columns.size());
  if (topic.samples == 0) return all;
  for (auto& values : all.values) make_room(values, topic.samples);
  if (two_clocks) {
    all.stamps.reserve(topic.samples);
    all.received.reserve(topic.samples);
  } else {
    make_room(all.seconds, topic.samples);
  }
  return all;
}

std::size_t samples_in(Stretches stretches) {
  std::size_t samples = 0;
  for (const Stretch* stretch : stretches)
    for (const Samples& of : *stretch) samples += of.count;
  return samples;
}

/// A vector that samples are appended to: a column, or after the last the stamps.
struct Destination {
  std::size_t topic, column;
};

std::vector<Gathered> gather(const Log& log, std::vector<Overview>& overviews, Played& played,
                             const Progress& progress) {
  std::vector<Gathered> all;
  std::vector<Destination> parts;
  for (std::size_t i = 0; i < log.topics.size(); ++i) {
    all.push_back(gathered_of(log.topics[i], log.two_clocks));
    for (std::size_t c = 0; c <= log.topics[i].columns.size(); ++c) parts.push_back({i, c});
  }
  const auto take = [&](Stretches stretches) {
    note(stretches, overviews);
    const auto append_part = [&](std::size_t p) {
      const auto [i, c] = parts[p];
      if (c == log.topics[i].columns.size())
        append_stamps(stretches, i, log.two_clocks, all[i]);
      else
        all[i].infinite[c] += append_values(stretches, log.topics[i].columns[c], i, c, all[i].values[c]);
    };
    if (samples_in(stretches) < few_samples)
      for (std::size_t p = 0; p < parts.size(); ++p) append_part(p);
    else
      parallel_for(parts.size(), append_part);
  };
  played = log.play(Want::samples, samples_at_once, take, progress);
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

/// The clock of a topic, of the two that it has.
void choose_of_two(const Topic& topic, Overview& overview, Findings& findings) {
  overview.choice = choose_clock(overview.clocks, topic.name, findings);
  overview.first = overview.choice.time(overview.clocks.first_stamp, overview.clocks.first_received);
}

/// The chosen clock of a topic that is in memory. `all.stamps` then has its times [ns].
void settle_clocks(const Topic& topic, std::optional<double> rate, Gathered& all, Overview& overview,
                   Findings& findings) {
  overview.clocks = summary_of(all);
  if (overview.clocks.out_of_order() && sort_by_time(all, overview.clocks.backward)) {
    overview.sorted = overview.clocks.backward;
    overview.clocks = summary_of(all);
  }
  choose_of_two(topic, overview, findings);
  file::EvenClock clock;
  for (std::size_t i = 0; i < all.stamps.size(); ++i) {
    all.stamps[i] = overview.choice.time(all.stamps[i], all.received[i]);
    clock.add(seconds_after(overview.first, all.stamps[i]), nanosecond);
  }
  overview.even = clock.timeline(rate);
}

/// Order and times of the samples of a topic that is in memory.
void settle(const Log& log, std::size_t topic, std::optional<double> rate, Gathered& all, Overview& overview,
            Findings& findings) {
  overview.infinite = std::accumulate(all.infinite.begin(), all.infinite.end(), std::size_t{0});
  if (log.two_clocks) return settle_clocks(log.topics[topic], rate, all, overview, findings);
  file::EvenClock clock;
  for (const double stamp : all.seconds) clock.add(stamp, microsecond);
  overview.even = clock.timeline(rate);
}

/// The times of samples that are not evenly spaced, whose clock is settled.
Seconds seconds_of(const Log& log, std::int64_t epoch, Gathered& all) {
  if (!log.two_clocks) return std::make_shared<const std::vector<double>>(std::move(all.seconds));
  std::vector<double> seconds(all.stamps.size());
  std::ranges::transform(all.stamps, seconds.begin(), [&](std::int64_t time) { return seconds_after(epoch, time); });
  return std::make_shared<const std::vector<double>>(std::move(seconds));
}

/// Hands the samples of the columns that are channels to them, in their order.
template <class Give>
void each_channel(const std::vector<Topic>& topics, const std::vector<Overview>& overviews, Recording& recording,
                  Give give) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < topics.size(); ++i)
    for (std::size_t c = 0; c < topics[i].columns.size(); ++c)
      if (is_channel(topics[i], overviews[i], c)) give(i, c, recording.channels[next++]);
}

}  // namespace

Recording read(const Log& log, std::optional<double> rate, const Progress& progress) {
  auto overviews = overviews_of(log.topics);
  Played played;
  auto all = gather(log, overviews, played, progress);
  Findings clock_findings;
  for (std::size_t i = 0; i < all.size(); ++i) settle(log, i, rate, all[i], overviews[i], clock_findings);
  const std::int64_t epoch = set_epoch(log, overviews);
  Recording recording = frame_of(log, overviews, epoch, played, clock_findings);
  std::vector<Seconds> stamps(all.size());
  each_channel(log.topics, overviews, recording, [&](std::size_t i, std::size_t c, Channel& channel) {
    const auto& even = overviews[i].even;
    channel.values = std::move(all[i].values[c]);
    if (!even && !stamps[i]) stamps[i] = seconds_of(log, epoch, all[i]);
    channel.timeline = even ? *even : Timeline{0.0, 0.0, stamps[i]};
  });
  return recording;
}

std::uintmax_t memory(const Log& log) {
  std::uintmax_t numbers = 0;
  for (const Topic& topic : log.topics) numbers += (topic.columns.size() + (log.two_clocks ? 2 : 1)) * topic.most;
  return numbers * sizeof(double);
}

namespace {

/// The clocks of a topic of which each sample is seen once: that of the log, or of two that of the instrument, and that
/// of the recorder.
struct SeenClocks {
  file::EvenClock own, recorder;

  void add(const Samples& samples, bool two_clocks, ClockSummary& summary) {
    if (!two_clocks)
      for (std::size_t i = 0; i < samples.count; ++i) own.add(samples.seconds[i], microsecond);
    else
      for (std::size_t i = 0; i < samples.count; ++i) {
        summary.add(samples.stamps[i], samples.received[i]);
        own.add(seconds_after(summary.first_stamp, samples.stamps[i]), nanosecond);
        recorder.add(seconds_after(summary.first_received, samples.received[i]), nanosecond);
      }
  }
};

std::size_t infinite_in(const Samples& samples) {
  std::size_t infinite = 0;
  for (const auto& column : samples.values)
    infinite += static_cast<std::size_t>(std::count_if(column.begin(),
                                                       column.begin() + static_cast<std::ptrdiff_t>(samples.count),
                                                       [](double value) { return std::isinf(value); }));
  return infinite;
}

/// A first way through the log: what is known before the first block is handed out.
std::vector<Overview> look_over(const Log& log, std::optional<double> rate, Played& played, Findings& findings) {
  auto overviews = overviews_of(log.topics);
  std::vector<SeenClocks> clocks(log.topics.size());
  const auto take = [&](Stretches stretches) {
    note(stretches, overviews);
    for (const Stretch* stretch : stretches)
      for (std::size_t i = 0; i < clocks.size(); ++i) {
        clocks[i].add((*stretch)[i], log.two_clocks, overviews[i].clocks);
        overviews[i].infinite += infinite_in((*stretch)[i]);
      }
  };
  played = log.play(Want::stamps, samples_at_once, take, {});
  for (std::size_t i = 0; i < overviews.size(); ++i) {
    if (log.two_clocks) choose_of_two(log.topics[i], overviews[i], findings);
    overviews[i].even = (overviews[i].choice.header ? clocks[i].own : clocks[i].recorder).timeline(rate);
  }
  return overviews;
}

/// Samples that wait to be handed out as a block.
class Blocks {
 public:
  Blocks(const Log& log, const std::vector<Overview>& overviews, std::int64_t epoch, Recording frame,
         std::size_t samples, const BlockSink& sink)
      : log_(log),
        overviews_(overviews),
        block_(std::move(frame)),
        samples_(samples),
        sink_(sink),
        epoch_(epoch),
        pending_(overviews.size()) {}

  void take(Stretches stretches) {
    for (const Stretch* stretch : stretches) {
      const Stretches only(&stretch, 1);
      each_channel(log_.topics, overviews_, block_, [&](std::size_t i, std::size_t c, Channel& channel) {
        pending_[i].infinite += append_values(only, log_.topics[i].columns[c], i, c, channel.values);
      });
      std::size_t longest = 0;
      for (std::size_t i = 0; i < pending_.size(); ++i) {
        take_times((*stretch)[i], overviews_[i], pending_[i]);
        longest = std::max(longest, pending_[i].count);
      }
      if (longest >= samples_) send();
    }
  }

  void send() {
    if (std::ranges::all_of(pending_, [](const Pending& pending) { return pending.count == 0; })) return;
    std::vector<Seconds> stamps;
    for (std::size_t i = 0; i < pending_.size(); ++i) {
      stamps.push_back(std::make_shared<const std::vector<double>>(std::move(pending_[i].seconds)));
      if (pending_[i].infinite > 0 && !overviews_[i].values_seen)
        block_.findings.push_back(infinite_samples(log_.topics[i], pending_[i].infinite));
    }
    each_channel(log_.topics, overviews_, block_, [&](std::size_t i, std::size_t, Channel& channel) {
      const auto& even = overviews_[i].even;
      channel.timeline =
          even ? Timeline{even->time(pending_[i].sent), even->rate, nullptr} : Timeline{0.0, 0.0, stamps[i]};
    });
    sink_(block_);
    block_.findings.clear();  // are said once
    for (Pending& pending : pending_) pending = {.sent = pending.sent + pending.count};
    for (Channel& channel : block_.channels) channel.values.clear();
  }

 private:
  /// The samples of a topic that wait.
  struct Pending {
    std::size_t sent = 0;              ///< those before them
    std::size_t count = 0;             ///< [1]
    std::size_t infinite = 0;          ///< values
    std::vector<double> seconds = {};  ///< where they are not evenly spaced
  };

  void take_times(const Samples& samples, const Overview& overview, Pending& pending) const {
    pending.count += samples.count;
    if (overview.even) return;
    if (!log_.two_clocks) return append(samples.seconds, samples.count, pending.seconds);
    for (std::size_t i = 0; i < samples.count; ++i)
      pending.seconds.push_back(seconds_after(epoch_, overview.choice.time(samples.stamps[i], samples.received[i])));
  }

  const Log& log_;
  const std::vector<Overview>& overviews_;
  Recording block_;
  std::size_t samples_;
  const BlockSink& sink_;
  std::int64_t epoch_;
  std::vector<Pending> pending_;
};

}  // namespace

void stream(const Log& log, std::optional<double> rate, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  Played played;
  Findings clock_findings;
  auto overviews = look_over(log, rate, played, clock_findings);
  // Messages that are not in order have to be sorted, and for that all of them must be there.
  if (std::ranges::any_of(overviews, [](const Overview& overview) { return overview.clocks.out_of_order(); }))
    return hand_out(read(log, rate, progress), samples, sink);
  const std::int64_t epoch = set_epoch(log, overviews);
  Blocks blocks(log, overviews, epoch, frame_of(log, overviews, epoch, played, clock_findings), samples, sink);
  log.play(
      Want::samples, samples, [&](Stretches stretches) { blocks.take(stretches); }, progress);
  blocks.send();
}

}  // namespace tumble::topics
