#pragma once

#include <cstddef>
#include <functional>
#include <future>

namespace tumble {

/// Calls body(i) for i = 0 .. count-1 on as many threads as the machine has. They begin in this order, so that one may
/// wait for those before it, and end in any, so body(i) may touch only what belongs to i; the result is then the same
/// for any number of threads. The first exception is rethrown. Between them it looks for an Interruption
/// (interruption.hpp). Work in the background has its processor: threads that could help wait until it ends.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

/// Calls a body for [0, count) in pieces: body(first, last). The length of the pieces is given, so that what is added
/// up within each does not depend on the number of threads.
void parallel_pieces(std::size_t count, std::size_t length, const std::function<void(std::size_t, std::size_t)>& body);

/// Does the work on a thread of its own, or when it is asked for where the system gives no thread.
std::future<void> in_background(std::function<void()> work);

}  // namespace tumble
