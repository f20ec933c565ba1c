#pragma once

#include <string>
#include <string_view>

#include "tumble/wire/frames.hpp"

namespace tumble {

/// The other side of the commands that start and stop a stream: an instrument that is silent until it has got all that
/// start it, in their order, and answers as its declaration expects.
class VirtualSwitch {
 public:
  explicit VirtualSwitch(FrameLink commands) : commands_(std::move(commands)) { power_on(); }

  /// Bytes that it has received. Returned: its answers.
  std::string receive(std::string_view bytes);
  void power_on();
  bool streams() const { return next_ == commands_.start.size(); }

 private:
  std::string obey(const std::string& command);

  FrameLink commands_;
  std::string pending_;   ///< that may be the begin of a command
  std::size_t next_ = 0;  ///< of the commands that start the stream
};

}  // namespace tumble
