#pragma once

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
  void clear();

 private:
  bool shown_;
  std::size_t lines_ = 0;
};

}  // namespace tumble::cli
