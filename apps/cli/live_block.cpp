#include "live_block.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "live_output.hpp"

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

/// What was drawn is erased, and the text drawn in its place.
std::string drawn(std::size_t& drawn_lines, const std::string& text) {
  std::string result = drawn_lines > 0 ? fmt::format("\033[{}A\033[J", drawn_lines) : "";
  drawn_lines = 0;
  if (text.empty()) return result;
  const winsize room = room_of_terminal();
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line) && drawn_lines + 1 < room.ws_row; ++drawn_lines)
    result += cut(line, room.ws_col) + "\n";
  return result;
}

}  // namespace

void LiveBlock::show(const std::string& text) {
  if (!shown_) return;
  if (is_output_live()) return put_live_drawing(this, [lines = lines_, text] { return drawn(*lines, text); });
  std::fputs(drawn(*lines_, text).c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace tumble::cli
