#include "tumble/serve/live_runs.hpp"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <thread>

#include "tumble/station/recorder.hpp"
#include "tumble/station/run_desk.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

/// A thread that reads what a run says, until the run ends.
struct LiveRuns::Watched {
  EventFeed feed{1};
  DeskWatch watch;
  std::atomic<bool> ended = false;
  std::mutex mutex;
  std::condition_variable changed;
  bool caught_up = false;
  std::thread thread;

  explicit Watched(const std::string& run) : watch(run), thread([this] { read(); }) {
    std::unique_lock lock(mutex);
    changed.wait_for(lock, std::chrono::seconds(5), [this] { return caught_up; });
  }
  Watched(const Watched&) = delete;
  Watched& operator=(const Watched&) = delete;
  ~Watched() {
    watch.close();
    thread.join();
  }

  void read() {
    std::uint64_t last = 0;
    while (const auto line = watch.next()) {
      last = std::max(last, line->sequence);
      if (line->name == "now")
        catch_up();
      else if (line->name != "end")
        feed.publish(line->name, line->json, last);
    }
    feed.publish("end", "{}", last);
    ended = true;
    catch_up();
  }

  void catch_up() {
    {
      const std::lock_guard lock(mutex);
      caught_up = true;
    }
    changed.notify_all();
  }
};

LiveRuns::~LiveRuns() = default;

std::shared_ptr<EventFeed> LiveRuns::feed_of(const std::string& run) {
  const std::lock_guard lock(mutex_);
  std::erase_if(watched_, [](const auto& entry) { return entry.second->ended.load(); });
  auto& watched = watched_[run];
  if (!watched) try {
      watched = std::make_shared<Watched>(run);
    } catch (...) {
      watched_.erase(run);
      throw;
    }
  return {watched, &watched->feed};
}

std::string LiveRuns::state_of(const std::string& run) {
  namespace fs = std::filesystem;
  try {
    return ask_desk(run, R"({"ask":"state"})");
  } catch (const Error& error) {
    if (error.kind != Error::Kind::unsupported) throw;
  }
  // What a killed run wrote last is in the log of the store alone.
  const auto now = [&] {
    std::string text;
    for (const char* const behind : {"", "-wal"}) {
      const fs::path file = (fs::path(run) / live_store_name).string() + behind;
      std::error_code failed;
      text += fmt::format("{} {} ", fs::last_write_time(file, failed).time_since_epoch().count(),
                          fs::file_size(file, failed));
    }
    return text;
  };
  const auto when = now();
  {
    const std::lock_guard lock(mutex_);
    if (const auto known = ended_.find(run); known != ended_.end() && known->second.when == when)
      return known->second.state;
  }
  auto state = state_of_ended_run(run);
  const std::lock_guard lock(mutex_);
  if (ended_.size() > 200) ended_.clear();
  ended_[run] = {now(), state};
  return state;
}

}  // namespace tumble
