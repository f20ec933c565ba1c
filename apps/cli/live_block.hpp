#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "terminal.hpp"

namespace tumble::cli {

/// Some lines on standard error that are drawn again in their place. Nothing unless the terminal is live.
class LiveBlock {
 public:
  explicit LiveBlock(const Terminal& terminal) : shown_(terminal.live && !terminal.quiet) {}
  LiveBlock(const LiveBlock&) = delete;
  LiveBlock& operator=(const LiveBlock&) = delete;
  ~LiveBlock() { clear(); }

  void show(const std::string& text);  ///< lines, each with its line break
  void clear() { show({}); }

 private:
  bool shown_;
  std::shared_ptr<std::size_t> lines_ = std::make_shared<std::size_t>(0);  ///< that stand there: known to who writes
};

}  // namespace tumble::cli
