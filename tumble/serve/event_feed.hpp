#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>

namespace tumble {

/// Events with growing numbers, kept for a while, so that a reader who lost the connection goes on where it was.
class EventFeed {
 public:
  /// The first event has the number `first` [1]: one that no earlier feed reached.
  explicit EventFeed(std::uint64_t first) : next_(first), oldest_(first) {}

  /// `name` and one line of JSON.
  void publish(const std::string& name, const std::string& data);
  /// With an id of its own, which never falls: a number of a journal. Readers see the id, `seen` stays the number.
  void publish(const std::string& name, const std::string& data, std::uint64_t id);
  /// Number of the latest event [1].
  std::uint64_t latest() const;
  /// `seen` of a reader who has seen all events up to this id; where some behind it are no longer kept, one that is
  /// answered by `reset`.
  std::uint64_t seen_by_id(std::uint64_t id) const;
  /// Events behind number `seen` [1] as text/event-stream; `seen` becomes that of the latest. Where some are no longer
  /// kept, or `seen` is of no event here, one event `reset`: the reader asks for everything again.
  std::string after(std::uint64_t& seen) const;
  /// Calls `wake` at each event, from any thread, until what is returned is destroyed.
  std::shared_ptr<void> subscribe(std::function<void()> wake);

 private:
  static constexpr std::size_t most_kept = 2000;

  void keep(std::uint64_t id, const std::string& name, const std::string& data);

  mutable std::mutex mutex_;
  std::uint64_t next_, oldest_;
  std::deque<std::pair<std::uint64_t, std::string>> kept_;  ///< id, text
  std::uint64_t dropped_id_ = 0;                            ///< the greatest that is no longer kept
  std::set<std::shared_ptr<std::function<void()>>> readers_;
};

}  // namespace tumble
