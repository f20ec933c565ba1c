#include "tumble/math/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "tumble/math/interruption.hpp"
#include "tumble/math/threads.hpp"

namespace tumble {
namespace {

std::atomic<std::size_t> most_threads{0};

}  // namespace

void limit_threads(std::size_t count) { most_threads = count; }

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex guard;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        stop_if_asked();
        body(i);
      } catch (...) {
        const std::lock_guard lock(guard);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  const std::size_t most = most_threads > 0 ? most_threads.load() : std::max(1u, std::thread::hardware_concurrency());
  const std::size_t helpers = std::min(count, most);
  const auto help = [&work, interruption = interruption_of_this_thread()] {
    share_interruption(interruption);
    work();
  };
  std::vector<std::thread> threads;
  try {
    for (std::size_t t = 1; t < helpers; ++t) threads.emplace_back(help);
  } catch (const std::system_error&) {  // no more threads to be had: those there are do it all
  }
  work();
  for (auto& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

void parallel_pieces(std::size_t count, std::size_t length, const std::function<void(std::size_t, std::size_t)>& body) {
  parallel_for((count + length - 1) / length,
               [&](std::size_t k) { body(k * length, std::min(count, (k + 1) * length)); });
}

std::future<void> in_background(std::function<void()> work) {
  try {
    return std::async(std::launch::async, work);
  } catch (const std::system_error&) {
    return std::async(std::launch::deferred, std::move(work));
  }
}

}  // namespace tumble
