#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tumble/wire/controller.hpp"

namespace tumble::conduct {

/// A controller at its wire: sends requests when the line has been quiet for as long as it wants, and collects replies.
/// Overdue replies are the executive's business: it asks again, which gives up what was outstanding. One that
/// comes late is no reply to what was asked after it.
class DeviceLine {
 public:
  /// `send`: bytes onto the wire. The controller must live as long.
  DeviceLine(const Controller& controller, std::function<void(std::string_view)> send);

  /// Returned: what can be said at once: refused where the controller cannot be asked so. `time` [s].
  std::vector<ControllerReply> ask(const ControllerRequest& request, double time);
  /// `time` [s].
  std::vector<ControllerReply> receive(std::string_view bytes, double time);
  /// Sends what is due. Returned: as ask(). `time` [s].
  std::vector<ControllerReply> at(double time);
  /// [s] when at() has something to do; infinity: not before something is received or asked.
  double next() const { return due_; }
  /// The link was lost: what was outstanding will not be answered.
  void restart();

 private:
  void say(std::string bytes, double time);
  std::vector<ControllerReply> after(std::vector<ControllerReply> replies, double time);

  ControllerHost host_;
  std::function<void(std::string_view)> send_;
  std::string waiting_;  ///< bytes that the line must be quiet for
  double due_;           ///< [s]
  double quiet_since_;   ///< [s]
  double asked_ = 0.0;   ///< [s] the last request
  double waited_ = 0.0;  ///< [s] for the reply that did not come: a late one is awaited as long again
};

}  // namespace tumble::conduct
