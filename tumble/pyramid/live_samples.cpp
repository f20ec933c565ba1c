#include "tumble/pyramid/live_samples.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "tumble/core/json_text.hpp"
#include "tumble/pyramid/store/live_file.hpp"

namespace tumble {
namespace live_samples {  // named, since Inner has them as members

using Json = nlohmann::json;
using store::LiveHead;

constexpr auto write_after = std::chrono::milliseconds(200);
constexpr std::size_t most_waiting = std::size_t{1} << 26;    ///< [byte] for a disk that does not answer
constexpr std::size_t most_in_record = std::size_t{1} << 20;  ///< samples

struct Waiting {
  std::vector<double> times, values;  ///< [s], [SI]
};

void put(std::string& bytes, const LiveHead& head, std::initializer_list<std::string_view> payload) {
  bytes.append(reinterpret_cast<const char*>(&head), sizeof head);
  for (const auto part : payload) bytes.append(part);
  bytes.resize((bytes.size() + 7) / 8 * 8, '\0');
}

std::string_view bytes_of_some(const std::vector<double>& numbers, std::size_t first, std::size_t count) {
  return {reinterpret_cast<const char*>(numbers.data() + first), count * sizeof(double)};
}

}  // namespace live_samples

using namespace live_samples;

struct LiveSamples::Inner {
  int descriptor = -1;
  std::uint64_t least_room;
  mutable std::mutex mutex;
  std::condition_variable changed;
  bool ended = false, failed = false;
  std::string texts;                                                    ///< records that come before the samples
  std::vector<Waiting> waiting;                                         ///< by channel
  std::vector<double> factors, latest;                                  ///< by channel; [s]
  std::map<std::pair<std::string, std::string>, std::size_t> channels;  ///< by slot and name
  std::size_t waits = 0;                                                ///< [byte]
  std::thread thread;

  void text(const Json& json) {
    const std::string line = json_text(json);
    put(texts, {LiveHead::text, 0, 0, static_cast<std::uint32_t>(line.size())}, {line});
  }
  std::size_t add_known(const std::string& slot, const std::string& name, double factor) {
    const auto [place, is_new] = channels.try_emplace({slot, name}, waiting.size());
    if (!is_new) return place->second;
    waiting.emplace_back();
    factors.push_back(factor);
    latest.push_back(-HUGE_VAL);
    return place->second;
  }
  bool open_file(const std::string& path);
  void read_channels(std::uint64_t end);
  void work();
  std::string taken();
  bool write(std::string_view bytes);
};

/// A file that is there is gone on with: behind its last whole record.
bool LiveSamples::Inner::open_file(const std::string& path) {
  descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  struct stat status {};
  if (descriptor < 0 || fcntl(descriptor, F_OFD_SETLK, &lock) != 0 || fstat(descriptor, &status) != 0 ||
      !S_ISREG(status.st_mode))
    return false;
  const std::uint64_t end = store::end_of_live_file(descriptor, static_cast<std::uint64_t>(status.st_size));
  if (ftruncate(descriptor, static_cast<off_t>(end)) != 0 || lseek(descriptor, 0, SEEK_END) < 0) return false;
  if (end == 0) return write({store::live_signature, 8});
  read_channels(end);
  return true;
}

void LiveSamples::Inner::read_channels(std::uint64_t end) {
  LiveHead head;
  for (std::uint64_t place = 8; place < end; place += head.length()) {
    if (!store::read_at(descriptor, place, &head, sizeof head)) return;
    if (head.kind != LiveHead::text) {
      double last = 0.0;  // the times of a record without its own were those of one before
      const bool timed = head.kind == LiveHead::timed && head.count > 0 && head.channel < latest.size();
      if (timed && store::read_at(descriptor, place + sizeof head + (head.count - 1) * sizeof last, &last, sizeof last))
        for (double& time : latest) time = std::max(time, last);
      continue;
    }
    std::string line(head.bytes, '\0');
    if (!store::read_at(descriptor, place + sizeof head, line.data(), line.size())) return;
    const Json json = Json::parse(line, nullptr, false);
    if (const auto channel = json.is_object() ? json.value("channel", Json()) : Json(); channel.is_object())
      add_known(channel.value("slot", ""), channel.value("name", ""), channel.value("factor", 1.0));
  }
}

void LiveSamples::Inner::work() {
  std::unique_lock lock(mutex);
  auto looked = std::chrono::steady_clock::time_point{};
  while (!failed) {
    changed.wait_for(lock, write_after, [this] { return ended; });
    const std::string bytes = taken();
    const bool last = ended;
    lock.unlock();
    bool good = true;
    if (const auto now = std::chrono::steady_clock::now(); now - looked > std::chrono::seconds(1)) {
      struct statvfs room {};
      good = fstatvfs(descriptor, &room) == 0 && room.f_bavail * std::uint64_t{room.f_frsize} >= least_room;
      looked = now;
    }
    good = good && write(bytes);
    lock.lock();
    if (!good) failed = true;
    if (last) return;
  }
  texts.clear();
  waiting.clear();
}

/// What waits, as records. Channels that were sampled at the same times share them.
std::string LiveSamples::Inner::taken() {
  std::string bytes = std::exchange(texts, {});
  const std::vector<double>* before = nullptr;
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    const Waiting& of = waiting[i];
    const std::size_t size = of.values.size();
    if (size == 0) continue;
    const bool same = before && size <= most_in_record && *before == of.times;
    for (std::size_t first = 0; first < size; first += most_in_record) {
      const std::size_t count = std::min(most_in_record, size - first);
      LiveHead head{same ? LiveHead::values : LiveHead::timed, static_cast<std::uint32_t>(i),
                    static_cast<std::uint32_t>(count),
                    static_cast<std::uint32_t>((same ? 1 : 2) * count * sizeof(double))};
      put(bytes, head,
          {same ? std::string_view() : bytes_of_some(of.times, first, count), bytes_of_some(of.values, first, count)});
    }
    before = &of.times;
  }
  for (Waiting& of : waiting) of.times.clear(), of.values.clear();
  waits = 0;
  return bytes;
}

bool LiveSamples::Inner::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t wrote = ::write(descriptor, bytes.data(), bytes.size());
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(wrote));
  }
  return true;
}

LiveSamples::LiveSamples(const std::string& path, std::uint64_t least_room) : inner_(std::make_unique<Inner>()) {
  inner_->least_room = least_room;
  try {
    inner_->failed = !inner_->open_file(path);
    if (!inner_->failed) inner_->thread = std::thread([inner = inner_.get()] { inner->work(); });
  } catch (const std::exception&) {  // no thread, no memory: the run goes on without a view
    inner_->failed = true;
  }
}

LiveSamples::~LiveSamples() {
  {
    const std::lock_guard lock(inner_->mutex);
    inner_->ended = true;
  }
  inner_->changed.notify_all();
  if (inner_->thread.joinable()) inner_->thread.join();
  if (inner_->descriptor >= 0) close(inner_->descriptor);
}

std::size_t LiveSamples::add(const Channel& channel) {
  const std::lock_guard lock(inner_->mutex);
  if (inner_->failed) return 0;
  const std::size_t before = inner_->waiting.size();
  const std::size_t number = inner_->add_known(channel.slot, channel.name, channel.factor);
  if (number == before)
    inner_->text({{"channel",
                   {{"name", channel.name},
                    {"slot", channel.slot},
                    {"unit", channel.unit.text()},
                    {"factor", channel.factor}}}});
  return number;
}

void LiveSamples::sample(std::size_t channel, double time, double value) {
  const std::lock_guard lock(inner_->mutex);
  if (inner_->failed || channel >= inner_->waiting.size()) return;
  Waiting& of = inner_->waiting[channel];
  inner_->latest[channel] = std::max(inner_->latest[channel], time);
  of.times.push_back(inner_->latest[channel]);
  of.values.push_back(std::isfinite(value) ? value * inner_->factors[channel] : std::nan(""));
  inner_->waits += 2 * sizeof(double);
  if (inner_->waits > most_waiting) inner_->failed = true;
}

void LiveSamples::begin_mark(const std::string& label, int run, double time) {
  const std::lock_guard lock(inner_->mutex);
  if (!inner_->failed) inner_->text({{"mark", {{"label", label}, {"run", run}, {"begin", time}}}});
}

void LiveSamples::end_mark(double time) {
  const std::lock_guard lock(inner_->mutex);
  if (!inner_->failed) inner_->text({{"mark_ends", time}});
}

void LiveSamples::fact(const std::string& name, const std::string& value) {
  const std::lock_guard lock(inner_->mutex);
  if (!inner_->failed) inner_->text({{"fact", {{name, value}}}});
}

bool LiveSamples::goes_on() const {
  const std::lock_guard lock(inner_->mutex);
  return !inner_->failed;
}

}  // namespace tumble
