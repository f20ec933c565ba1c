#include "tumble/station/conduct/stream_line.hpp"

#include <fmt/format.h>

#include <limits>
#include <utility>

namespace tumble::conduct {
namespace {

constexpr double not_due = std::numeric_limits<double>::infinity();
constexpr std::size_t most_heard = 1 << 16;  ///< [byte] that are searched for an answer

/// For a message: the end of it, without what a terminal would not show.
std::string printable(std::string text) {
  if (text.size() > 60) text = "..." + text.substr(text.size() - 60);
  for (char& letter : text)
    if (letter < ' ' || letter > '~') letter = '.';
  return text;
}

}  // namespace

StreamLine::StreamLine(const FrameLink& commands, std::function<void(std::string_view)> send, double within)
    : commands_(&commands), send_(std::move(send)), within_(within), due_(not_due) {}

void StreamLine::start(double time) {
  starting_ = true;
  next_ = 0;
  go_on(time);
}

void StreamLine::stop() {
  starting_ = false;
  due_ = not_due;
  for (const auto& [bytes, expected] : commands_->stop) send_(bytes);
}

void StreamLine::link_is_up(double time) {
  if (starting_) start(time);
}

/// Sends until an answer is awaited.
void StreamLine::go_on(double time) {
  due_ = time + within_;
  heard_.clear();
  for (; next_ < commands_->start.size(); ++next_) {
    send_(commands_->start[next_].first);
    if (!commands_->start[next_].second.empty()) return;
  }
}

bool StreamLine::receive(std::string_view bytes, bool has_frame, double time) {
  if (!starting_) return false;
  if (answered()) {
    if (!has_frame) return false;
    starting_ = false;
    due_ = not_due;
    return true;
  }
  heard_ += bytes;
  if (heard_.find(commands_->start[next_].second) != std::string::npos) {
    ++next_;
    go_on(time);
  } else if (heard_.size() > most_heard) {
    heard_.erase(0, heard_.size() - most_heard / 2);
  }
  return false;
}

Sentence StreamLine::what_is_missing() const {
  if (answered()) return say("no frame came within {:.3g} s after the commands that start the stream", within_);
  const auto& [sent, expected] = commands_->start[next_];
  return say("the instrument did not answer '{}' with '{}' within {:.3g} s, but with {} bytes: '{}'", printable(sent),
             expected, within_, heard_.size(), printable(heard_));
}

Sentence StreamLine::at(double time) {
  if (time < due_) return {};
  const Sentence missing = what_is_missing();
  start(time);
  return missing;
}

}  // namespace tumble::conduct
