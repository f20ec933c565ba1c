#pragma once

#include <condition_variable>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "tumble/recorder/live_store/front.hpp"

namespace tumble::live_store {

/// Takes what waits at the front to the disk, batch after batch, on a thread of its own where that is wanted.
class Writer {
 public:
  Writer(std::string folder, Disk& disk, const RecorderOptions& options);
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer();

  /// Calls work(front) if the recording goes on; 0 else.
  template <class Work>
  std::uint64_t append(Work work) {
    std::unique_lock lock(mutex_);
    if (failure_ || closed_) return 0;
    const bool waited = !front_.empty();
    const std::uint64_t result = work(front_);
    load_.most_pending = std::max(load_.most_pending, front_.bytes());
    if (holds_ == 0) look_for_overflow();
    if (!waited || front_.urgent()) changed_.notify_all();
    return result;
  }

  /// Until as many releases nothing is taken from the front, and no failure falls between.
  void hold();
  void release();

  bool flush(double within = std::numeric_limits<double>::infinity());  ///< [s]
  Acknowledged acknowledged() const;
  std::optional<StoreFailure> failure() const;
  StoreLoad load() const;
  /// Closes the store as Recorder::close() does; time [s].
  bool close(double time, const Sentence& ending);

 private:
  void look_for_overflow();
  void work();
  void wait_for_wholes(std::unique_lock<std::mutex>& lock);
  /// Writes one batch; the lock is not held meanwhile.
  void commit_one(std::unique_lock<std::mutex>& lock);
  bool try_write(const Batch& batch, std::unique_lock<std::mutex>& lock);
  void handle(const Refusal& refusal, Batch batch, std::unique_lock<std::mutex>& lock);
  void fail(StoreFailure::Kind kind, Sentence text);
  void report_failure(std::unique_lock<std::mutex>& lock);
  void tidy(std::unique_lock<std::mutex>& lock);
  void look_for_store();
  void end_thread();

  std::string folder_;
  Disk& disk_;
  RecorderOptions options_;
  std::optional<StoreFile> store_;
  std::uint64_t inode_ = 0, log_inode_ = 0;  ///< of the store and of its log, 0: not known
  Front front_;
  Acknowledged acknowledged_;
  std::optional<StoreFailure> failure_;
  bool reported_ = false, closed_ = false, stopping_ = false;
  std::uint64_t asked_ = 0, answered_ = 0;  ///< flushes
  int holds_ = 0;
  StoreLoad load_;
  mutable std::mutex mutex_;
  std::condition_variable changed_, written_, whole_;
  std::thread thread_;
};

}  // namespace tumble::live_store
