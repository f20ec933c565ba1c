#pragma once

#include <chrono>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace tumble {

/// Orders to stop runs. Whoever waits while a run is being asked gets the answer of the next time it is asked, with all
/// who came before that: a run that does not answer keeps nobody waiting more than twice.
class Stops {
 public:
  using Clock = std::chrono::steady_clock;

  /// Stops a run as stop_run() does, `patience` [s], for an order that came at `came`.
  void stop(const std::string& run, const std::string& who, double patience, Clock::time_point came);

 private:
  struct Asked {
    std::mutex mutex;  ///< held while the run is asked
    Clock::time_point begun;
    std::exception_ptr problem;  ///< what it gave; null: it has taken the order
  };
  std::shared_ptr<Asked> asked_of(const std::string& run);

  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Asked>> asked_;
};

}  // namespace tumble
