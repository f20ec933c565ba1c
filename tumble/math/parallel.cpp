#include "tumble/math/parallel.hpp"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "tumble/math/interruption.hpp"
#include "tumble/math/threads.hpp"

namespace tumble {
namespace {

std::atomic<std::size_t> most_threads{0};

std::size_t threads_at_most() {
  return most_threads > 0 ? most_threads.load() : std::max(1u, std::thread::hardware_concurrency());
}

/// A thread for each processor: who works for parallel_for() and in the background is counted, and helpers wait until
/// a processor is free. Else they would take turns with a job that nobody can help, such as a checksum, which then ends
/// last and alone.
class Processors {
 public:
  void occupy() {
    const std::lock_guard lock(guard_);
    ++busy_;
  }
  void release() {
    {
      const std::lock_guard lock(guard_);
      --busy_;
    }
    changed_.notify_all();
  }
  /// Waits for a free one; false where `done` becomes true before.
  bool take(const bool& done) {
    std::unique_lock lock(guard_);
    changed_.wait(lock, [&] { return done || busy_ < threads_at_most(); });
    busy_ += done ? 0 : 1;
    return !done;
  }
  /// Wakes those who wait in vain.
  void finish(bool& done) {
    {
      const std::lock_guard lock(guard_);
      done = true;
    }
    changed_.notify_all();
  }
  void begin_background() {
    const std::lock_guard lock(guard_);
    ++background_;
  }
  void end_background() {
    {
      const std::lock_guard lock(guard_);
      --background_;
    }
    changed_.notify_all();
  }
  /// Waits until nothing works in the background, and keeps it so until the fork is done.
  void before_fork() {
    std::unique_lock lock(guard_);
    changed_.wait(lock, [&] { return background_ == 0; });
    lock.release();
  }
  void after_fork() { guard_.unlock(); }

 private:
  std::mutex guard_;
  std::condition_variable changed_;
  std::size_t busy_ = 0;        ///< threads
  std::size_t background_ = 0;  ///< threads of in_background
};

Processors* all_processors = nullptr;  ///< outlive every thread

void count_anew_in_child();

Processors& processors() {
  static const bool once = [] {
    all_processors = new Processors;
    pthread_atfork([] { all_processors->before_fork(); }, [] { all_processors->after_fork(); }, count_anew_in_child);
    return true;
  }();
  static_cast<void>(once);
  return *all_processors;
}

/// This thread is counted as long as the object lives, once.
class AtWork {
 public:
  AtWork() : first_(!counted_) {
    if (first_) processors().occupy();
    counted_ = true;
  }
  AtWork(const AtWork&) = delete;
  AtWork& operator=(const AtWork&) = delete;
  ~AtWork() {
    if (!first_) return;
    counted_ = false;
    processors().release();
  }
  static void here(const std::function<void()>& work) {
    const AtWork at_work;
    work();
  }
  /// A helper, whose processor was taken.
  static void help(const std::function<void()>& work) {
    counted_ = true;
    work();
    processors().release();
  }
  static bool is_counted() { return counted_; }

 private:
  static thread_local bool counted_;
  bool first_;
};

thread_local bool AtWork::counted_ = false;

/// The child of a fork has one thread: locks, and who waited for them, are those of threads that it does not have.
void count_anew_in_child() {
  all_processors = new Processors;
  if (AtWork::is_counted()) all_processors->occupy();
}

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
  const AtWork at_work;
  const std::size_t helpers = std::min(count, threads_at_most());
  bool done = false;
  const auto help = [&work, &done, interruption = interruption_of_this_thread()] {
    share_interruption(interruption);
    if (processors().take(done)) AtWork::help(work);
  };
  std::vector<std::thread> threads;
  try {
    for (std::size_t t = 1; t < helpers; ++t) threads.emplace_back(help);
  } catch (const std::system_error&) {  // no more threads to be had: those there are do it all
  }
  work();
  if (!threads.empty()) processors().finish(done);
  for (auto& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

void parallel_pieces(std::size_t count, std::size_t length, const std::function<void(std::size_t, std::size_t)>& body) {
  parallel_for((count + length - 1) / length,
               [&](std::size_t k) { body(k * length, std::min(count, (k + 1) * length)); });
}

namespace {

/// A thread that is joined where its owner is given up. In the child of a fork it does not exist, and its work is done.
class Joined {
 public:
  explicit Joined(std::thread thread) : thread_(new std::thread(std::move(thread))) {}
  Joined(const Joined&) = delete;
  Joined& operator=(const Joined&) = delete;
  ~Joined() {
    if (getpid() != home_) return;
    thread_->join();
    delete thread_;
  }

 private:
  std::thread* thread_;
  pid_t home_ = getpid();
};

}  // namespace

/// Whoever gives up what is returned waits for the work, and so does a fork(): the child, which does not have the
/// thread, finds the work done.
std::future<void> in_background(std::function<void()> work) {
  std::promise<void> promise;
  auto done = promise.get_future().share();
  processors().begin_background();
  try {
    auto joined = std::make_shared<Joined>(std::thread([work, promise = std::move(promise)]() mutable {
      try {
        AtWork::here(work);
        promise.set_value();
      } catch (...) {
        promise.set_exception(std::current_exception());
      }
      processors().end_background();
    }));
    return std::async(std::launch::deferred, [done = std::move(done), joined = std::move(joined)] { done.get(); });
  } catch (const std::system_error&) {
    processors().end_background();
    return std::async(std::launch::deferred, std::move(work));
  }
}

}  // namespace tumble
