#include "terminal.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tumble/units/error.hpp"

namespace tumble::cli {

namespace {

/// Text of files, arguments and names may hold bytes that steer a terminal (escape sequences, C1 controls in UTF-8).
std::string harmless(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const bool c1 = byte == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) - 0x80u < 0x20u;
    if (c1 || byte == 0x7f || (byte < 0x20 && byte != '\n' && byte != '\t'))
      out += "\uFFFD", i += c1;
    else
      out += text[i];
  }
  return out;
}

/// A log that is closed or full does not spoil what was done.
void say(const std::string& text) { std::fputs(text.c_str(), stderr); }

}  // namespace

Terminal terminal_of_process() {
  Terminal terminal;
  const char* kind = std::getenv("TERM");
  const char* no_colour = std::getenv("NO_COLOR");
  terminal.live = isatty(STDERR_FILENO) == 1 && !(kind && std::string_view(kind) == "dumb");
  terminal.colour = terminal.live && !(no_colour && *no_colour);
  return terminal;
}

void print(std::string_view raw) {
  const std::string text = harmless(raw);
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written) throw Error(Error::Kind::bad_file, fmt::format("standard output: {}", std::strerror(errno)));
}

void note(const Terminal& terminal, const std::string& message) {
  if (!terminal.quiet) say(fmt::format("tumble: {}\n", harmless(message)));
}

void complain(const Terminal& terminal, const std::vector<std::string>& problems) {
  std::string text = terminal.colour ? "\033[1;31merror:\033[0m" : "error:";
  for (std::size_t i = 0; i < problems.size(); ++i) text += (i ? "       " : " ") + harmless(problems[i]) + "\n";
  say(text);
}

Progress ProgressLine::progress() {
  if (!shown_) return {};
  return [this](double done, std::string_view what) { draw(done, what); };
}

void ProgressLine::draw(double done, std::string_view what) {
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  constexpr int width = 30;
  const double part = std::clamp(done, 0.0, 1.0);
  const auto full = static_cast<int>(part * width);
  say(fmt::format("\r\033[K[{:#<{}}{:.<{}}] {:3.0f} % {}", "", full, "", width - full, 100.0 * part, what));
  std::fflush(stderr);
}

ProgressLine::~ProgressLine() {
  if (!drawn_) return;
  say("\r\033[K");
  std::fflush(stderr);
}

}  // namespace tumble::cli
