#include "live_output.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <utility>

#include "tumble/language/said.hpp"
#include "tumble/recorder/quiet_thread.hpp"
#include "tumble/units/error.hpp"

namespace tumble::cli {
namespace {

constexpr std::size_t most_output = std::size_t{1} << 20;  ///< [byte] that wait
constexpr auto longest_flush = std::chrono::seconds(2);

struct Piece {
  int descriptor = STDERR_FILENO;
  std::string text;
  const void* owner = nullptr;  ///< of a drawing
  std::function<std::string()> draw = {};
};

/// [byte] that it takes in the queue.
std::size_t size_of(const Piece& piece) { return piece.draw ? 4096 : 64 + piece.text.size(); }

/// What the thread shares with those who speak. A thread that hangs in a write outlives the rest.
struct OutputQueue {
  std::mutex mutex;
  std::condition_variable changed, written;
  std::deque<Piece> pieces;
  std::size_t bytes = 0, not_shown = 0;  ///< of what waits; lines that were given up
  bool busy = false, ended = false;
  int output_error = 0;  ///< errno of standard output
  bool quiet = false;
  Language language = Language::english;

  void add(Piece piece);
  void work();
  std::string words_of_gap(std::size_t lines) const;
};

std::shared_ptr<OutputQueue>& output_queue() {
  static std::shared_ptr<OutputQueue> queue;
  return queue;
}

/// errno; 0: all is written.
int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const auto count = write(descriptor, text.data(), text.size());
    if (count >= 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      pollfd room{descriptor, POLLOUT, 0};
      poll(&room, 1, 1000);
    } else if (errno != EINTR) {
      return errno;
    }
  }
  return 0;
}

void OutputQueue::add(Piece piece) {
  if (piece.owner && !pieces.empty() && pieces.back().owner == piece.owner) {
    bytes -= size_of(pieces.back());
    pieces.pop_back();
  }
  bytes += size_of(piece);
  pieces.push_back(std::move(piece));
  while (bytes > most_output && pieces.size() > 1) {
    const std::string& oldest = pieces.front().text;
    not_shown += static_cast<std::size_t>(std::count(oldest.begin(), oldest.end(), '\n'));
    bytes -= size_of(pieces.front());
    pieces.pop_front();
  }
  changed.notify_all();
}

std::string OutputQueue::words_of_gap(std::size_t lines) const {
  if (quiet || lines == 0) return "";
  const Sentence said = say("{} lines are not shown: nothing could be written for a while", lines);
  return fmt::format("tumble: {}\n", in_language(language, said));
}

void OutputQueue::work() {
  std::unique_lock lock(mutex);
  for (;;) {
    changed.wait(lock, [this] { return ended || !pieces.empty(); });
    if (pieces.empty()) return;
    const Piece piece = std::move(pieces.front());
    pieces.pop_front();
    bytes -= size_of(piece);
    const std::string gap = words_of_gap(std::exchange(not_shown, 0));
    busy = true;
    lock.unlock();
    if (!gap.empty()) write_all(STDERR_FILENO, gap);
    const int error = write_all(piece.descriptor, piece.draw ? piece.draw() : piece.text);
    lock.lock();
    busy = false;
    if (error != 0 && piece.descriptor == STDOUT_FILENO && output_error == 0) output_error = error;
    written.notify_all();
  }
}

[[noreturn]] void refuse_output(int error) {
  throw Error(Error::Kind::bad_file, say("standard output: {}", system_reason(error)));
}

}  // namespace

void begin_live_output(const Terminal& terminal) {
  auto& queue = output_queue();
  if (queue) return;
  queue = std::make_shared<OutputQueue>();
  queue->quiet = terminal.quiet;
  queue->language = terminal.language;
  quiet_thread([queue = queue] { queue->work(); }).detach();
}

bool is_output_live() { return output_queue() != nullptr; }

void put_live(int descriptor, std::string text) {
  const auto queue = output_queue();
  const std::lock_guard lock(queue->mutex);
  if (descriptor == STDOUT_FILENO && queue->output_error != 0) refuse_output(queue->output_error);
  queue->add({descriptor, std::move(text)});
}

void put_live_drawing(const void* owner, std::function<std::string()> draw) {
  const auto queue = output_queue();
  const std::lock_guard lock(queue->mutex);
  queue->add({STDERR_FILENO, {}, owner, std::move(draw)});
}

void flush_live_output() {
  const auto queue = output_queue();
  if (!queue) return;
  std::unique_lock lock(queue->mutex);
  queue->written.wait_for(lock, longest_flush, [&] { return queue->pieces.empty() && !queue->busy; });
  if (queue->output_error != 0) refuse_output(queue->output_error);
}

void end_live_output() {
  const auto queue = output_queue();
  if (!queue) return;
  try {
    flush_live_output();
  } catch (const Error&) {  // who wants to know has asked before
  }
  const std::lock_guard lock(queue->mutex);
  queue->ended = true;
  queue->changed.notify_all();
}

}  // namespace tumble::cli
