#pragma once

#include <functional>

namespace tumble {

/// While it lives, long work that this thread begins calls `ask` between its pieces, on this thread alone. An exception
/// of `ask` ends the work of all threads that take part, and the work throws it: this is how Ctrl+C of a notebook ends
/// the work.
class Interruption {
 public:
  explicit Interruption(std::function<void()> ask);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  struct State;  ///< what the threads of one work share

 private:
  State* state_;
};

/// The place where work may end: between two pieces. Does nothing where nobody asks.
/// Throws    what `ask` throws
void stop_if_asked();

/// The interruption of this thread, for a thread that helps it; null for none.
Interruption::State* interruption_of_this_thread();

/// Lets this thread end with the work that it helps.
void share_interruption(Interruption::State* of_another_thread);

}  // namespace tumble
