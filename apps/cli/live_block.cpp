#include "live_block.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <sstream>

namespace tumble::cli {

namespace {

/// Lines and characters that the terminal shows: a block that does not fit cannot be drawn in its place.
winsize room_of_terminal() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_row == 0) size.ws_row = 24, size.ws_col = 80;
  return size;
}

/// At most so many bytes of a line, without a cut through a character of UTF-8.
std::string cut(std::string line, std::size_t most) {
  std::size_t characters = 0, end = 0;
  while (end < line.size() && characters < most) {
    ++end;
    while (end < line.size() && (static_cast<unsigned char>(line[end]) & 0xc0) == 0x80) ++end;
    ++characters;
  }
  return line.substr(0, end);
}

}  // namespace

void LiveBlock::show(const std::string& text) {
  if (!shown_) return;
  const winsize room = room_of_terminal();
  std::string drawn = lines_ > 0 ? fmt::format("\033[{}A\033[J", lines_) : "";
  std::istringstream lines(text);
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line) && count + 1 < room.ws_row; ++count)
    drawn += cut(line, room.ws_col) + "\n";
  lines_ = count;
  std::fputs(drawn.c_str(), stderr);
  std::fflush(stderr);
}

void LiveBlock::clear() {
  if (!shown_ || lines_ == 0) return;
  std::fputs(fmt::format("\033[{}A\033[J", lines_).c_str(), stderr);
  std::fflush(stderr);
  lines_ = 0;
}

}  // namespace tumble::cli
