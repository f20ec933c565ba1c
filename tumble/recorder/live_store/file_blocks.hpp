#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "tumble/core/recording.hpp"

namespace tumble::live_store {

/// The blocks of a recording in a file one after the other, which a thread of its own reads a little ahead.
class FileBlocks {
 public:
  /// `samples` of a channel in a block, about.
  FileBlocks(std::string path, std::size_t samples);
  FileBlocks(const FileBlocks&) = delete;
  FileBlocks& operator=(const FileBlocks&) = delete;
  ~FileBlocks();
  /// Nothing behind the last one. Throws what reading throws.
  std::optional<Recording> next();

 private:
  void read(const std::string& path, std::size_t samples);
  void put(const Recording& block);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Recording> ready_;
  std::exception_ptr failure_;
  bool ended_ = false, unwanted_ = false;
  std::thread thread_;
};

}  // namespace tumble::live_store
