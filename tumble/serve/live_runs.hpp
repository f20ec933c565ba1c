#pragma once

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

  /// What happens at a run. An id is the sequence number of the live store up to which the reader has seen everything.
  /// Throws Error::unsupported: the run does not go on.
  std::shared_ptr<EventFeed> feed_of(const std::string& run);
  /// The state of a run, as JSON: asked of it where it goes on, else read from its store. Throws Error::bad_file.
  std::string state_of(const std::string& run);

 private:
  struct Watched;
  struct Read {
    std::string when, state;
  };
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Watched>> watched_;
  std::map<std::string, Read> ended_;  ///< states of runs that have ended, while their stores do not change
};

}  // namespace tumble
