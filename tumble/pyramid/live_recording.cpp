#include "tumble/pyramid/live_recording.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "tumble/pyramid/store/live_file.hpp"
#include "tumble/pyramid/store/live_track.hpp"
#include "tumble/pyramid/store/store.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

using store::Json, store::LiveHead;

namespace live_recording {  // named, since Inner has them as members

constexpr std::uint64_t most_in_look = std::uint64_t{1} << 26;  // [byte]

/// What grows of one channel, and its pages.
struct Growing {
  std::string name, slot;
  Unit unit;
  store::Levels levels;
  std::vector<store::LiveRun> runs;
  std::vector<double> bar_times;
  double last = 0.0;  ///< [s]

  struct PagesOfLevel {
    store::SharedPages<float> low, high;
    store::SharedPages<std::uint8_t> flags;
  };
  std::vector<PagesOfLevel> level_pages;
  std::vector<store::SharedPages<Moments>> moment_pages;
  store::SharedPages<store::LiveRun> run_pages;
  store::SharedPages<double> time_pages;
};

using Owners = std::vector<std::shared_ptr<const void>>;

store::MappedChannel channel_of(Growing& of, const std::shared_ptr<const store::OpenFile>& file, Owners& owners) {
  of.levels.finish();
  store::MappedChannel channel;
  channel.count = of.levels.samples();
  channel.offset = of.levels.offset();
  std::size_t complete = channel.count / store::moment_block * store::factor;  // bars that will not change
  of.level_pages.resize(of.levels.levels().size());
  for (std::size_t k = 0; k < of.level_pages.size(); ++k, complete /= store::factor) {
    const store::Level& level = of.levels.levels()[k];
    auto& pages = of.level_pages[k];
    channel.levels.push_back({level.low.size(), pages.low.share(level.low, complete, owners),
                              pages.high.share(level.high, complete, owners),
                              pages.flags.share(level.flags, complete, owners)});
  }
  complete = channel.count / store::moment_block;
  of.moment_pages.resize(of.levels.moments().size());
  for (std::size_t k = 0; k < of.moment_pages.size(); ++k, complete /= store::factor) {
    const auto& level = of.levels.moments()[k];
    channel.moments.push_back({level.size(), of.moment_pages[k].share(level, complete, owners)});
  }
  auto track = std::make_shared<store::LiveTrack>();
  track->file = file;
  track->count = channel.count;
  track->run_count = of.runs.size();
  track->runs = of.run_pages.share(of.runs, of.runs.size(), owners);
  track->bar_times = of.time_pages.share(of.bar_times, of.bar_times.size(), owners);
  channel.track = std::move(track);
  return channel;
}

}  // namespace live_recording

using namespace live_recording;

struct LiveRecording::Inner {
  std::shared_ptr<const store::OpenFile> file;
  std::string path;
  std::mutex growing, showing;  ///< of what grows; of `state`
  State state;
  std::uint64_t place = 0;  ///< up to which the file was read
  std::uint64_t times = 0;  ///< place of the times of the last record that had some
  std::uint32_t times_count = 0;
  std::vector<Growing> channels;
  std::vector<Mark> marks;
  std::string instrument;

  void take(std::uint64_t size);
  bool take_record(const LiveHead& head);
  void take_text(const std::string& line);
  std::shared_ptr<const Pyramid> pyramid();
  std::vector<char> payload;
  std::vector<double> numbers;
};

void LiveRecording::Inner::take_text(const std::string& line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object()) return;
  if (json.contains("channel")) {
    const Json& of = json["channel"];
    channels.push_back({of.value("name", ""), of.value("slot", ""), Unit::parse(of.value("unit", "1")), {}, {}, {}});
  } else if (json.contains("mark")) {
    const Json& of = json["mark"];
    marks.push_back({of.value("label", ""), of.value("begin", 0.0), of.value("run", 1)});
  } else if (json.contains("mark_ends") && !marks.empty()) {
    marks.back().end = json["mark_ends"].get<double>();
  } else if (json.contains("fact")) {
    state.target = json["fact"].value("target", state.target);
    instrument = json["fact"].value("instrument", instrument);
  }
}

/// False: it cannot be.
bool LiveRecording::Inner::take_record(const LiveHead& head) {
  const std::uint64_t begin = place + sizeof head;
  if (head.kind == LiveHead::text) {
    std::string line(head.bytes, '\0');
    if (!store::read_at(file->descriptor, begin, line.data(), line.size())) return false;
    take_text(line);
    return true;
  }
  if (head.channel >= channels.size() || head.count == 0) return false;
  Growing& channel = channels[head.channel];
  const bool timed = head.kind == LiveHead::timed;
  if (timed) times = begin, times_count = head.count;
  if (head.count > times_count) return false;
  numbers.resize(2 * std::size_t{head.count});
  const std::uint64_t values = timed ? begin + head.count * sizeof(double) : begin;
  if (!store::read_at(file->descriptor, times, numbers.data(), head.count * sizeof(double)) ||
      !store::read_at(file->descriptor, values, numbers.data() + head.count, head.count * sizeof(double)))
    return false;
  const std::size_t before = channel.levels.samples();
  for (std::size_t i = (store::finest - before % store::finest) % store::finest; i < head.count; i += store::finest)
    channel.bar_times.push_back(numbers[i]);
  channel.runs.push_back({before, times, values});
  channel.levels.add(numbers.data() + head.count, numbers.data(), head.count);
  channel.last = numbers[head.count - 1];
  return true;
}

void LiveRecording::Inner::take(std::uint64_t size) {
  const std::uint64_t most = place + most_in_look;
  LiveHead head;
  while (place < most && store::read_at(file->descriptor, place, &head, sizeof head)) {
    if (!head.plausible()) throw Error{Error::Kind::bad_file, say("'{}' is damaged", path)};
    if (head.length() > size - place) break;  // it is still being written
    if (!take_record(head)) throw Error{Error::Kind::bad_file, say("'{}' is damaged", path)};
    place += head.length();
  }
}

std::shared_ptr<const Pyramid> LiveRecording::Inner::pyramid() {
  PyramidMoment moment;
  store::LiveChannels live;
  std::set<std::string> slots;
  for (const Growing& channel : channels) slots.insert(channel.slot);
  moment.header.instrument = instrument;
  moment.header.marks = marks;
  for (Growing& channel : channels) {
    const std::string name =
        slots.size() > 1 && !channel.slot.empty() ? channel.slot + "." + channel.name : channel.name;
    moment.header.channels.push_back({name, kind_of(channel.unit), channel.unit, {}, {}});
    live.channels.push_back(channel_of(channel, file, live.owners));
    const std::size_t count = live.channels.back().count;
    moment.channels.push_back({name, kind_of(channel.unit), channel.unit, count,
                               count > 0 ? channel.bar_times.front() : 0.0, channel.last, true});
  }
  moment.store = std::move(live);
  return std::make_shared<const Pyramid>(std::move(moment));
}

LiveRecording::LiveRecording(const std::string& path) : inner_(std::make_unique<Inner>()) {
  inner_->path = path;
  inner_->file = std::make_shared<const store::OpenFile>(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status {};
  if (inner_->file->descriptor < 0 || fstat(inner_->file->descriptor, &status) != 0 || !S_ISREG(status.st_mode))
    throw Error{Error::Kind::bad_file, say("'{}' cannot be read", path)};
  char signature[8];
  if (!store::read_at(inner_->file->descriptor, 0, signature, 8) ||
      std::string_view(signature, 8) != std::string_view(store::live_signature, 8))
    throw Error{Error::Kind::bad_file, say("'{}' does not hold the samples of a run", path)};
  inner_->place = 8;
}

LiveRecording::~LiveRecording() = default;

LiveRecording::State LiveRecording::look() {
  Inner& inner = *inner_;
  std::unique_lock grows(inner.growing, std::try_to_lock);
  if (!grows) {
    {
      const std::lock_guard lock(inner.showing);
      if (inner.state.pyramid) return inner.state;
    }
    grows.lock();  // the first look of all
  }
  struct stat status {};
  const bool going_on = store::is_written(inner.file->descriptor);  // before the size: what was written last is seen
  if (fstat(inner.file->descriptor, &status) != 0)
    throw Error{Error::Kind::bad_file, say("'{}' cannot be read", inner.path)};
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size < inner.place) throw Error{Error::Kind::bad_file, say("'{}' was cut off: load the page again", inner.path)};
  const std::uint64_t before = inner.place;
  try {
    inner.take(size);
  } catch (const Json::exception&) {
    throw Error{Error::Kind::bad_file, say("'{}' is damaged", inner.path)};
  }
  const std::lock_guard lock(inner.showing);
  if (inner.place != before || !inner.state.pyramid) inner.state.pyramid = inner.pyramid();
  inner.state.going_on = going_on;
  inner.state.behind = inner.place - before >= most_in_look;
  return inner.state;
}

}  // namespace tumble
