#include "tumble/math/interruption.hpp"

#include <atomic>
#include <exception>
#include <thread>
#include <utility>

namespace tumble {

struct Interruption::State {
  std::function<void()> ask;
  std::thread::id asks = std::this_thread::get_id();
  State* outer = nullptr;
  std::exception_ptr reason;  ///< is written once, before `ended`
  std::atomic<bool> ended{false};
};

namespace {

thread_local Interruption::State* state_of_this_thread = nullptr;

}  // namespace

Interruption::Interruption(std::function<void()> ask) : state_(new State) {
  state_->ask = std::move(ask);
  state_->outer = std::exchange(state_of_this_thread, state_);
}

Interruption::~Interruption() {
  state_of_this_thread = state_->outer;
  delete state_;
}

void stop_if_asked() {
  Interruption::State* const state = state_of_this_thread;
  if (state == nullptr) return;
  if (state->ended) std::rethrow_exception(state->reason);
  if (state->asks != std::this_thread::get_id()) return;
  try {
    state->ask();
  } catch (...) {
    state->reason = std::current_exception();
    state->ended = true;
    throw;
  }
}

Interruption::State* interruption_of_this_thread() { return state_of_this_thread; }

void share_interruption(Interruption::State* of_another_thread) { state_of_this_thread = of_another_thread; }

}  // namespace tumble
