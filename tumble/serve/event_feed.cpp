#include "tumble/serve/event_feed.hpp"

#include <fmt/format.h>

namespace tumble {

void EventFeed::publish(const std::string& name, const std::string& data) {
  const std::lock_guard lock(mutex_);
  kept_.push_back(fmt::format("id: {}\nevent: {}\ndata: {}\n\n", next_++, name, data));
  if (kept_.size() > most_kept) kept_.pop_front(), ++oldest_;
  for (const auto& wake : readers_) (*wake)();
}

std::uint64_t EventFeed::latest() const {
  const std::lock_guard lock(mutex_);
  return next_ - 1;
}

std::string EventFeed::after(std::uint64_t& seen) const {
  const std::lock_guard lock(mutex_);
  std::string text;
  if (seen + 1 < oldest_ || seen >= next_)
    text = fmt::format("id: {}\nevent: reset\ndata: {{}}\n\n", next_ - 1);
  else
    for (std::uint64_t number = seen + 1; number < next_; ++number) text += kept_[number - oldest_];
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
