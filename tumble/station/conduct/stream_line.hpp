#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "tumble/wire/frames.hpp"

namespace tumble::conduct {

/// An instrument at its wire whose stream is started by commands: they are sent one after the other, each when the one
/// before is answered, and all again where an answer or the first frame does not come. How long this may go on is the
/// business of others.
class StreamLine {
 public:
  /// `commands` of the declaration, which must live as long. `send`: bytes onto the wire. `within` [s]: for an answer.
  StreamLine(const FrameLink& commands, std::function<void(std::string_view)> send, double within);

  void start(double time);  ///< [s]
  /// Sends the commands that stop the stream; nothing is awaited any more.
  void stop();
  /// The link came back: what was sent before may be lost. `time` [s].
  void link_is_up(double time);
  /// Takes bytes that have arrived at `time` [s], and whether a frame with channels was among them. Returned: the
  /// stream runs from now on.
  bool receive(std::string_view bytes, bool has_frame, double time);
  /// Sends all again where something is overdue at `time` [s]. Returned: what did not come; empty: nothing is overdue.
  Sentence at(double time);
  /// [s] when at() has something to do; infinity: it has nothing.
  double next() const { return due_; }
  bool answered() const { return next_ == commands_->start.size(); }  ///< all that starts it

 private:
  void go_on(double time);
  Sentence what_is_missing() const;

  const FrameLink* commands_;
  std::function<void(std::string_view)> send_;
  double within_, due_;   ///< [s]
  std::size_t next_ = 0;  ///< of the commands that start it: the one that waits for its answer
  std::string heard_;     ///< since it was sent
  bool starting_ = false;
};

}  // namespace tumble::conduct
