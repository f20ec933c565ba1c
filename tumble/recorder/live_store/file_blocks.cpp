#include "tumble/recorder/live_store/file_blocks.hpp"

#include <utility>

#include "tumble/formats/format.hpp"

namespace tumble::live_store {
namespace {

constexpr std::size_t blocks_ahead = 2;

struct NobodyReads {};

}  // namespace

FileBlocks::FileBlocks(std::string path, std::size_t samples)
    : thread_([this, path = std::move(path), samples] { read(path, samples); }) {}

FileBlocks::~FileBlocks() {
  {
    const std::lock_guard lock(mutex_);
    unwanted_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void FileBlocks::read(const std::string& path, std::size_t samples) {
  std::exception_ptr failure;
  try {
    stream_recording(format_of(path), path, {}, samples, [this](const Recording& block) { put(block); }, {});
  } catch (const NobodyReads&) {
  } catch (...) {
    failure = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  failure_ = failure;
  ended_ = true;
  changed_.notify_all();
}

void FileBlocks::put(const Recording& block) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return unwanted_ || ready_.size() < blocks_ahead; });
  if (unwanted_) throw NobodyReads();
  ready_.push_back(block);
  changed_.notify_all();
}

std::optional<Recording> FileBlocks::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return ended_ || !ready_.empty(); });
  if (ready_.empty() && failure_) std::rethrow_exception(failure_);
  if (ready_.empty()) return std::nullopt;
  Recording block = std::move(ready_.front());
  ready_.pop_front();
  changed_.notify_all();
  return block;
}

}  // namespace tumble::live_store
