#include "tumble/serve/stops.hpp"

#include "tumble/desk/run_desk.hpp"

namespace tumble {

std::shared_ptr<Stops::Asked> Stops::asked_of(const std::string& run) {
  constexpr std::size_t many = 200;
  const std::lock_guard lock(mutex_);
  if (asked_.size() > many) std::erase_if(asked_, [](const auto& entry) { return entry.second.use_count() == 1; });
  auto& asked = asked_[run];
  if (!asked) asked = std::make_shared<Asked>();
  return asked;
}

void Stops::stop(const std::string& run, const std::string& who, double patience, Clock::time_point came) {
  const auto asked = asked_of(run);
  const std::lock_guard lock(asked->mutex);
  if (asked->begun > came) {
    if (asked->problem) std::rethrow_exception(asked->problem);
    return;
  }
  asked->begun = Clock::now();
  asked->problem = nullptr;
  try {
    stop_run(run, who, patience);
  } catch (...) {
    asked->problem = std::current_exception();
    throw;
  }
}

}  // namespace tumble
