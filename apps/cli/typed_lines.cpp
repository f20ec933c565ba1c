#include "typed_lines.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>

#include "tumble/recorder/quiet_thread.hpp"

namespace tumble::cli {
namespace {

constexpr std::size_t longest_line = 4096;  ///< [byte] nobody types more
constexpr std::size_t most_lines = 64;      ///< that wait: the rest stays where it is
constexpr int look_again = 1000;            ///< [ms] whether a terminal belongs to this process again

/// What the thread shares with the one who asks. A thread that hangs in a read outlives the rest.
struct TypedLines {
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::string> lines;
  std::string part;  ///< of the thread alone

  void add(std::string_view bytes);
  void work();
};

std::shared_ptr<TypedLines>& typed_lines() {
  static std::shared_ptr<TypedLines> lines;
  return lines;
}

void TypedLines::add(std::string_view bytes) {
  part.append(bytes);
  for (auto end = part.find('\n'); end != std::string::npos; end = part.find('\n')) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [this] { return lines.size() < most_lines; });
    lines.push_back(part.substr(0, end));
    part.erase(0, end + 1);
  }
  if (part.size() > longest_line) part.clear();
}

void TypedLines::work() {
  char bytes[256];
  for (;;) {
    const auto count = read(STDIN_FILENO, bytes, sizeof bytes);
    if (count > 0) {
      add({bytes, static_cast<std::size_t>(count)});
    } else if (count < 0 && (errno == EIO || errno == EAGAIN)) {  // in the background of a terminal
      poll(nullptr, 0, look_again);
    } else if (count == 0 || errno != EINTR) {
      return;
    }
  }
}

}  // namespace

void begin_typed_lines() {
  auto& lines = typed_lines();
  if (lines) return;
  lines = std::make_shared<TypedLines>();
  quiet_thread([lines = lines] { lines->work(); }).detach();
}

std::optional<std::string> next_typed_line() {
  const auto lines = typed_lines();
  if (!lines) return std::nullopt;
  const std::lock_guard lock(lines->mutex);
  if (lines->lines.empty()) return std::nullopt;
  std::string line = std::move(lines->lines.front());
  lines->lines.pop_front();
  lines->changed.notify_all();
  return line;
}

}  // namespace tumble::cli
