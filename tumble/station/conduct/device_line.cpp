#include "tumble/station/conduct/device_line.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "tumble/units/error.hpp"

namespace tumble::conduct {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

}  // namespace

DeviceLine::DeviceLine(const Controller& controller, std::function<void(std::string_view)> send)
    : host_(controller), send_(std::move(send)), due_(never), quiet_since_(-never) {}

std::vector<ControllerReply> DeviceLine::ask(const ControllerRequest& request, double time) {
  if (!host_.idle()) {
    host_.give_up();
    waited_ = time - asked_;
  }
  waiting_.clear();
  due_ = never;
  asked_ = time;
  try {
    const std::string bytes = host_.ask(request);
    if (host_.waits_for_quiet()) {
      due_ = time + waited_;
      return {};
    }
    say(bytes, time);
  } catch (const Error& error) {
    ControllerReply reply;
    reply.verb = request.verb;
    reply.axis = request.axis;
    reply.refused = true;
    reply.text = reason_of(error);
    return {reply};
  }
  return due_ == never ? after(host_.feed({}), time) : std::vector<ControllerReply>{};
}

std::vector<ControllerReply> DeviceLine::receive(std::string_view bytes, double time) {
  quiet_since_ = time;
  constexpr std::size_t most_at_once = 1024;  // [byte]: what is left of them is moved with each line
  const bool waited = host_.waits_for_quiet();
  std::vector<ControllerReply> replies;
  for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), most_at_once)))
    for (auto& reply : host_.feed(bytes.substr(0, most_at_once))) replies.push_back(std::move(reply));
  if (waited && !host_.waits_for_quiet()) due_ = never;
  return after(std::move(replies), time);
}

std::vector<ControllerReply> DeviceLine::at(double time) {
  if (time < due_) return {};
  due_ = never;
  if (host_.waits_for_quiet()) {
    host_.line_is_clear();
    return after({}, time);
  }
  quiet_since_ = time;
  send_(std::exchange(waiting_, {}));
  return after(host_.feed({}), time);
}

void DeviceLine::restart() {
  if (!host_.idle()) host_.give_up();
  host_.line_is_clear();
  waiting_.clear();
  due_ = never;
}

void DeviceLine::say(std::string bytes, double time) {
  if (time >= quiet_since_ + host_.pause()) {
    quiet_since_ = time;
    send_(bytes);
    return;
  }
  waiting_ = std::move(bytes);
  due_ = quiet_since_ + host_.pause();
}

std::vector<ControllerReply> DeviceLine::after(std::vector<ControllerReply> replies, double time) {
  for (std::string more = host_.next(); !more.empty(); more = host_.next()) {
    say(std::move(more), time);
    if (due_ != never) break;
    for (auto& reply : host_.feed({})) replies.push_back(std::move(reply));
  }
  return replies;
}

}  // namespace tumble::conduct
