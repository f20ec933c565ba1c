#include "tumble/formats/frames/read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/frames/choose.hpp"
#include "tumble/formats/frames/findings.hpp"
#include "tumble/formats/frames/groups.hpp"
#include "tumble/units/error.hpp"

namespace tumble::frames {

namespace {

constexpr std::size_t chunk = std::size_t{1} << 20;  // bytes
constexpr std::size_t all_stamps = std::numeric_limits<std::size_t>::max();

/// One pass through a file: hands out each sample of each group with its time.
class Pass {
 public:
  Pass(const std::string& path, const ReadOptions& options, const Chosen& chosen)
      : path_(path), chosen_(chosen), stream_(chosen.codec), steps_(steps_of(chosen.codec)) {
    timed_ = has_time(beginning_of(path));
    rate_ = options.rate.value_or(chosen.codec.rate);
  }

  /// take(frame, t [s], step [s] of the clock)
  template <class Take>
  void run(const Progress& progress, Take take) {
    file::InputFile file(path_);
    std::vector<char> bytes(chunk);
    std::size_t done = 0;
    const FrameSink sink = [&](const StreamFrame& frame) {
      if (timed_ && !frame.time) return;  // before the clock is known
      if (!timed_ && !(rate_ > 0.0)) refuse_without_rate();
      const double t = timed_ ? *frame.time : static_cast<double>(frame.sequence) / rate_;
      take(frame, t, timed_ ? steps_[frame.content.frame] : 0.0);
    };
    while (const std::size_t count = file.read(bytes.data(), bytes.size())) {
      report(progress, static_cast<double>(done) / static_cast<double>(file.size() + 1), "reading");
      stream_.feed({bytes.data(), count}, sink);
      done += count;
    }
    stream_.finish(sink);
    if (stream_.counts().channel_frames == 0)
      throw Error(Error::Kind::bad_file,
                  say("'{}' holds no frame of {} that carries a channel: {} bytes, {} frames that are damaged", path_,
                      Name{chosen_.codec.name}, stream_.counts().bytes, stream_.counts().damaged.count));
  }

  const FrameCounts& counts() const { return stream_.counts(); }

 private:
  [[noreturn]] void refuse_without_rate() const {
    throw Error(Error::Kind::bad_file, say("'{}': the frames of {} have no time; give their rate "
                                           "(--set rate=1000)",
                                           path_, Name{chosen_.codec.name}));
  }

  bool has_time(const std::string& bytes) const {
    bool timed = false;
    const FrameSink sink = [&](const StreamFrame& frame) { timed = timed || frame.time; };
    FrameStream stream(chosen_.codec);
    stream.feed(bytes, sink);
    stream.finish(sink);
    return timed;
  }

  std::string path_;
  const Chosen& chosen_;
  FrameStream stream_;
  std::vector<double> steps_;
  bool timed_ = false;
  double rate_ = 0.0;
};

/// What the channels of each group have in common once the whole stream was seen.
struct GroupClock {
  std::optional<Timeline> even;
  double per_sample = 1.0;  ///< [1/s] by which increments are multiplied
};

std::vector<GroupClock> clocks_of(const std::vector<Group>& groups, const ReadOptions& options, const Chosen& chosen,
                                  const std::string& path) {
  std::vector<GroupClock> clocks;
  for (const Group& group : groups) {
    GroupClock clock;
    clock.even = group.clock.timeline(options.rate);
    if (group.increments && group.count > 0) {
      clock.per_sample = rate_of(group);
      if (!(clock.per_sample > 0.0)) clock.per_sample = options.rate.value_or(chosen.codec.rate);
      if (!(clock.per_sample > 0.0))
        throw Error(Error::Kind::bad_file, say("'{}': '{}' counts increments, and the time of a sample does not "
                                               "show; give the rate (--set rate=1000)",
                                               path, chosen.codec.channels[group.channels[0]].name));
    }
    if (group.count == 1)
      clock.even = Timeline{group.stamps[0], std::max(options.rate.value_or(chosen.codec.rate), 1.0)};
    clocks.push_back(clock);
  }
  return clocks;
}

/// The channels that the stream holds, without samples, group after group.
Recording frame_of(const std::string& path, const Chosen& chosen, const std::vector<Group>& groups) {
  Recording recording;
  recording.instrument = chosen.codec.title;
  recording.origin.file = path;
  recording.meta["frames"] = chosen.codec.name;
  recording.recognised = {{"frames", chosen.codec.name}, {"device", chosen.codec.title}};
  for (const Group& group : groups)
    for (const std::size_t i : group.channels) {
      const FrameChannel& channel = chosen.codec.channels[i];
      if (group.count > 0) recording.channels.push_back({channel.name, kind_of(channel.unit), channel.unit, {}, {}});
    }
  if (recording.channels.empty())
    throw Error(Error::Kind::bad_file, say("'{}': its frames carry none of the channels that are wanted", path));
  return recording;
}

Timeline timeline_of(const GroupClock& clock, std::size_t before, std::vector<double> stamps) {
  if (clock.even) return {clock.even->time(before), clock.even->rate, nullptr};
  return {0.0, 0.0, std::make_shared<const std::vector<double>>(std::move(stamps))};
}

/// Multiplies increments by the rate, in place.
void to_rates(const FrameChannel& channel, const GroupClock& clock, std::vector<double>& values) {
  if (!channel.increment) return;
  for (double& value : values) value *= clock.per_sample;
}

void refuse_text_options(const std::string& path, const ReadOptions& options) {
  if (!options.segment_column.empty())
    throw Error(Error::Kind::bad_file, say("'{}' is raw bytes: segment_column is for text tables", path));
}

}  // namespace

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress) {
  refuse_text_options(path, options);
  auto checksum = sha256_in_background(path);
  const Chosen chosen = choose(path, options);
  auto groups = groups_of(chosen.codec, options.only);
  std::vector<std::vector<double>> values(chosen.codec.channels.size());
  Pass pass(path, options, chosen);
  pass.run(progress, [&](const StreamFrame& frame, double t, double step) {
    for (Group& group : groups) {
      if (!frame.content.present[group.channels.front()]) continue;
      group.add(t, step, all_stamps);
      for (const std::size_t i : group.channels) values[i].push_back(frame.content.values[i]);
    }
  });
  Recording recording = frame_of(path, chosen, groups);
  const auto clocks = clocks_of(groups, options, chosen, path);
  auto channel = recording.channels.begin();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (groups[g].count == 0) continue;
    const Timeline timeline = timeline_of(clocks[g], 0, std::move(groups[g].stamps));
    for (const std::size_t i : groups[g].channels) {
      to_rates(chosen.codec.channels[i], clocks[g], values[i]);
      channel->timeline = timeline;
      channel++->values = std::move(values[i]);
    }
  }
  recording.findings = findings_of(chosen, pass.counts(), path);
  recording.origin.checksum = std::move(checksum);
  return recording;
}

namespace {

/// Samples of some groups on their way to a sink.
class Blocks {
 public:
  Blocks(const Chosen& chosen, const std::vector<Group>& groups, const std::vector<GroupClock>& clocks, Recording frame)
      : chosen_(chosen),
        groups_(groups),
        clocks_(clocks),
        block_(std::move(frame)),
        values_(chosen.codec.channels.size()),
        stamps_(groups.size()),
        sent_(groups.size()) {}

  void add(const FrameContent& content, double t) {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const auto& channels = groups_[g].channels;
      if (!content.present[channels.front()]) continue;
      if (!clocks_[g].even) stamps_[g].push_back(t);
      for (const std::size_t i : channels) values_[i].push_back(content.values[i]);
      longest_ = std::max(longest_, values_[channels.front()].size());
    }
  }

  std::size_t longest() const { return longest_; }  ///< samples of the channel with the most

  void send(const BlockSink& sink) {
    auto channel = block_.channels.begin();
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const std::size_t count = values_[groups_[g].channels.front()].size();
      const Timeline timeline = timeline_of(clocks_[g], sent_[g], std::exchange(stamps_[g], {}));
      for (const std::size_t i : groups_[g].channels) {
        to_rates(chosen_.codec.channels[i], clocks_[g], values_[i]);
        channel->timeline = timeline;
        channel++->values = std::exchange(values_[i], {});
      }
      sent_[g] += count;
    }
    longest_ = 0;
    sink(block_);
  }

 private:
  const Chosen& chosen_;
  const std::vector<Group>& groups_;
  const std::vector<GroupClock>& clocks_;
  Recording block_;
  std::vector<std::vector<double>> values_, stamps_;  ///< by channel of the codec, by group
  std::vector<std::size_t> sent_;
  std::size_t longest_ = 0;
};

}  // namespace

void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  refuse_text_options(path, options);
  const Chosen chosen = choose(path, options);
  auto groups = groups_of(chosen.codec, options.only);
  Pass first(path, options, chosen);
  first.run({}, [&](const StreamFrame& frame, double t, double step) {
    for (Group& group : groups)
      if (frame.content.present[group.channels.front()]) group.add(t, step, group.increments ? stamps_for_rate : 1);
  });
  Recording block = frame_of(path, chosen, groups);
  block.findings = findings_of(chosen, first.counts(), path);
  std::erase_if(groups, [](const Group& group) { return group.count == 0; });
  const auto clocks = clocks_of(groups, options, chosen, path);
  Blocks blocks(chosen, groups, clocks, std::move(block));
  Pass second(path, options, chosen);
  second.run(progress, [&](const StreamFrame& frame, double t, double) {
    blocks.add(frame.content, t);
    if (blocks.longest() >= samples) blocks.send(sink);
  });
  if (blocks.longest() > 0) blocks.send(sink);
}

std::uintmax_t memory(const std::string& path, const ReadOptions& options) {
  const Chosen chosen = choose(path, options);
  const auto groups = groups_of(chosen.codec, options.only);
  const std::string bytes = beginning_of(path);
  std::uintmax_t samples = 0;
  FrameStream stream(chosen.codec);
  const FrameSink sink = [&](const StreamFrame& frame) {
    for (const Group& group : groups)
      if (frame.content.present[group.channels.front()]) samples += group.channels.size() + 1;
  };
  stream.feed(bytes, sink);
  stream.finish(sink);
  const double share = static_cast<double>(samples) / static_cast<double>(std::max<std::size_t>(bytes.size(), 1));
  return static_cast<std::uintmax_t>(share * static_cast<double>(file::InputFile(path).size())) * sizeof(double);
}

}  // namespace tumble::frames
