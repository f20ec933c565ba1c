#include "tumble/serve/event_feed.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace tumble {

void EventFeed::publish(const std::string& name, const std::string& data) {
  const std::lock_guard lock(mutex_);
  keep(next_, name, data);
}

void EventFeed::publish(const std::string& name, const std::string& data, std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  keep(id, name, data);
}

void EventFeed::keep(std::uint64_t id, const std::string& name, const std::string& data) {
  kept_.emplace_back(id, fmt::format("id: {}\nevent: {}\ndata: {}\n\n", id, name, data));
  ++next_;
  if (kept_.size() > most_kept) {
    dropped_id_ = kept_.front().first;
    kept_.pop_front();
    ++oldest_;
  }
  for (const auto& wake : readers_) (*wake)();
}

std::uint64_t EventFeed::seen_by_id(std::uint64_t id) const {
  const std::lock_guard lock(mutex_);
  if (id < dropped_id_) return oldest_ > 1 ? oldest_ - 2 : 0;
  const auto behind = std::ranges::upper_bound(kept_, id, {}, [](const auto& entry) { return entry.first; });
  return oldest_ + static_cast<std::uint64_t>(behind - kept_.begin()) - 1;
}

std::uint64_t EventFeed::latest() const {
  const std::lock_guard lock(mutex_);
  return next_ - 1;
}

std::string EventFeed::after(std::uint64_t& seen) const {
  const std::lock_guard lock(mutex_);
  std::string text;
  if (seen + 1 < oldest_ || seen >= next_)
    text = fmt::format("id: {}\nevent: reset\ndata: {{}}\n\n", kept_.empty() ? next_ - 1 : kept_.back().first);
  else
    for (std::uint64_t number = seen + 1; number < next_; ++number) text += kept_[number - oldest_].second;
  seen = next_ - 1;
  return text;
}

std::shared_ptr<void> EventFeed::subscribe(std::function<void()> wake) {
  auto entry = std::make_shared<std::function<void()>>(std::move(wake));
  const std::lock_guard lock(mutex_);
  readers_.insert(entry);
  return {nullptr, [this, entry](void*) {
            const std::lock_guard leaving(mutex_);
            readers_.erase(entry);
          }};
}

}  // namespace tumble
