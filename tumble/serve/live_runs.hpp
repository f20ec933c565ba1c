#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "tumble/serve/event_feed.hpp"

namespace tumble {

/// The runs that somebody watches through this server: one connection to each, however many pages show it.
class LiveRuns {
 public:
  LiveRuns() = default;
  LiveRuns(const LiveRuns&) = delete;
  LiveRuns& operator=(const LiveRuns&) = delete;
  ~LiveRuns();

  /// Events of a run. An id is the sequence number of the live store up to which the reader has seen everything.
  /// Throws Error::unsupported: the run does not go on.
  std::shared_ptr<EventFeed> feed_of(const std::string& run);
  /// The state of a run, as JSON: asked of it where it goes on, else read from its store. A run is asked once for all
  /// who want it meanwhile, and one that has not answered is left alone for a moment. Throws Error::bad_file.
  std::string state_of(const std::string& run);

  static constexpr double patience = 2.5;  ///< [s] until a run must have answered

 private:
  struct Watched;
  struct Read {
    std::string when, state;
  };
  /// State of a run, asked once for all who wait for it; each run has its own, so that a question to one does not wait
  /// for another.
  struct Asked {
    std::mutex mutex;  ///< held while it is asked
    std::chrono::steady_clock::time_point silent_until;
    std::shared_ptr<Watched> watched;
  };
  std::shared_ptr<Asked> asked_of(const std::string& run);
  std::string ask_once(const std::string& run);

  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Asked>> asked_;
  std::map<std::string, Read> ended_;  ///< states of runs that have ended, while their stores do not change
};

}  // namespace tumble
