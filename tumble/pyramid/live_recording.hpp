#pragma once

#include <memory>
#include <string>

#include "tumble/pyramid/pyramid.hpp"

namespace tumble {

/// A recording that is being made, as LiveSamples writes it. Several threads may look at it at once.
class LiveRecording {
 public:
  /// How it is at a moment.
  struct State {
    std::shared_ptr<const Pyramid> pyramid;  ///< of the samples so far; what comes later does not change it
    bool going_on = false;                   ///< somebody writes it
    bool behind = false;                     ///< more was there than one look takes: look again
    std::string target;                      ///< file that it becomes, from its folder; empty: not known
  };

  /// Throws Error::bad_file.
  explicit LiveRecording(const std::string& path);
  LiveRecording(const LiveRecording&) = delete;
  LiveRecording& operator=(const LiveRecording&) = delete;
  ~LiveRecording();

  /// Takes what came since the last look, 64 MB at most; where another thread is at it, what is known.
  /// Throws Error::bad_file.
  State look();

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

}  // namespace tumble
