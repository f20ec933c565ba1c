#pragma once

#include <deque>
#include <utility>

#include "tumble/station/executive.hpp"

namespace tumble::conduct {

/// Events of a run on their way to the executive, in the order in which they happened.
class EventQueue {
 public:
  /// Whether more has arrived than the event that is put in next: nobody is judged silent before it was looked at.
  void expect(bool more) { more_ = more; }
  /// An event of `time` [s].
  void put(decltype(RunEvent::what) what, double time) {
    events_.push_back({time, std::move(what), more_});
    unjudged_ = more_;
  }
  /// Since the last event that was put in, nobody has looked whether a device is silent.
  bool is_unjudged() const { return unjudged_; }

  /// Hands each event to `handle`. What `handle` puts in meanwhile comes after it, and drains nothing itself.
  template <class Handle>
  void drain(const Handle& handle) {
    if (busy_) return;
    busy_ = true;
    while (!events_.empty()) {
      const RunEvent event = std::move(events_.front());
      events_.pop_front();
      handle(event);
    }
    busy_ = false;
  }

 private:
  std::deque<RunEvent> events_;
  bool busy_ = false, more_ = false, unjudged_ = false;
};

}  // namespace tumble::conduct
