#include "tumble/serve/live_runs.hpp"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <thread>

#include "tumble/desk/run_desk.hpp"
#include "tumble/recorder/recorder.hpp"
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
    changed.wait_for(lock, std::chrono::duration<double>(patience), [this] { return caught_up; });
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

/// Runs that nobody watches any more go, where there are many.
std::shared_ptr<LiveRuns::Asked> LiveRuns::asked_of(const std::string& run) {
  constexpr std::size_t many = 200;
  const std::lock_guard lock(mutex_);
  if (asked_.size() > many)
    std::erase_if(asked_, [](const auto& entry) {
      return entry.second.use_count() == 1 && (!entry.second->watched || entry.second->watched->ended);
    });
  auto& asked = asked_[run];
  if (!asked) asked = std::make_shared<Asked>();
  return asked;
}

std::shared_ptr<EventFeed> LiveRuns::feed_of(const std::string& run) {
  const auto asked = asked_of(run);
  const std::lock_guard lock(asked->mutex);
  if (asked->watched && asked->watched->ended) asked->watched.reset();
  if (!asked->watched) asked->watched = std::make_shared<Watched>(run);
  return {asked->watched, &asked->watched->feed};
}

/// Who comes while a run does not answer is told at once.
std::string LiveRuns::ask_once(const std::string& run) {
  using Clock = std::chrono::steady_clock;
  constexpr auto pause = std::chrono::seconds(2);
  const auto asked = asked_of(run);
  const std::lock_guard lock(asked->mutex);
  if (Clock::now() < asked->silent_until) throw Error{Error::Kind::bad_file, say("the run '{}' has not answered", run)};
  try {
    return ask_desk(run, R"({"ask":"state"})", patience);
  } catch (const Error& error) {
    if (error.kind == Error::Kind::bad_file) asked->silent_until = Clock::now() + pause;
    throw;
  }
}

std::string LiveRuns::state_of(const std::string& run) {
  namespace fs = std::filesystem;
  try {
    return ask_once(run);
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
