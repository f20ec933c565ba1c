#include "terminal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "live_output.hpp"
#include "tumble/language/said.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/report/utf8.hpp"
#include "tumble/units/error.hpp"

namespace tumble::cli {

namespace {

/// A log that is closed or full does not spoil what was done.
void put_message(const std::string& text) {
  if (is_output_live()) return put_live(STDERR_FILENO, text);
  std::fputs(text.c_str(), stderr);
}

}  // namespace

namespace {

/// Tables narrower than 60 characters cannot be read, lines of more than 160 neither.
std::size_t width_of_process() {
  winsize size{};
  if (isatty(STDOUT_FILENO) != 1 || ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 100;
  return std::clamp<std::size_t>(size.ws_col, 60, 160);
}

}  // namespace

Terminal terminal_of_process() {
  Terminal terminal;
  const char* kind = std::getenv("TERM");
  const char* no_colour = std::getenv("NO_COLOR");
  terminal.live = isatty(STDERR_FILENO) == 1 && !(kind && std::string_view(kind) == "dumb");
  terminal.width = width_of_process();
  terminal.colour = terminal.live && !(no_colour && *no_colour);
  return terminal;
}

Language language_of_process(const std::vector<std::string>& words) {
  std::string code;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--lang" && i + 1 < words.size()) code = words[i + 1];
    if (words[i].starts_with("--lang=")) code = words[i].substr(7);
  }
  for (const char* name : {"LC_ALL", "LC_MESSAGES", "LANG"})
    if (const char* value = std::getenv(name); code.empty() && value) code = value;
  return code.starts_with("zh") ? Language::chinese : Language::english;
}

void print(std::string_view raw) {
  const std::string text = printable_lines(raw);
  if (is_output_live()) return put_live(STDOUT_FILENO, text);
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written) throw Error(Error::Kind::bad_file, say("standard output: {}", system_reason(errno)));
}

void print_said(const Terminal& terminal, const Sentence& said) { print(in_language(terminal.language, said)); }

std::string table_said(const Terminal& terminal, std::vector<TextColumn> columns) {
  for (TextColumn& column : columns) column.name = in_language(terminal.language, Sentence(column.name.c_str()));
  return text_table(columns, terminal.width);
}

void note(const Terminal& terminal, const Sentence& message) {
  if (!terminal.quiet)
    put_message(fmt::format("tumble: {}\n", printable_lines(in_language(terminal.language, message))));
}

void complain(const Terminal& terminal, const Problems& problems) {
  const std::string word = terminal.language == Language::chinese ? "错误：" : "error:";
  const std::string blank = terminal.language == Language::chinese ? "" : " ";  // the full-width colon has its own
  std::string text = (terminal.colour ? "\033[1;31m" + word + "\033[0m" : word) + blank;
  for (std::size_t i = 0; i < problems.size(); ++i)
    text += (i ? "      " + blank : "") + printable_lines(in_language(terminal.language, problems[i])) + "\n";
  put_message(text);
}

namespace {

/// The descriptor that an environment variable names. -1: none.
int descriptor_of(const char* variable) {
  const char* text = std::getenv(variable);
  const int descriptor = text ? std::atoi(text) : -1;
  return descriptor > STDERR_FILENO && fcntl(descriptor, F_GETFD) >= 0 ? descriptor : -1;
}

/// Lines "0.25 reading" are written to it, at most ten a second, in place of what a terminal shows.
int progress_descriptor() { return descriptor_of("TUMBLE_PROGRESS"); }

}  // namespace

void hand_on(Error::Kind kind, const Problems& problems) {
  const int other = descriptor_of("TUMBLE_PROBLEMS"), descriptor = other >= 0 ? other : progress_descriptor();
  if (descriptor < 0) return;
  std::signal(SIGPIPE, SIG_IGN);  // who has started this one may have ended
  const std::string line = "problems " + problems_to_json(code_of(kind), problems, Language::english) + "\n";
  for (std::size_t done = 0; done < line.size();) {
    const auto count = write(descriptor, line.data() + done, line.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    done += static_cast<std::size_t>(count);
  }
}

ProgressLine::ProgressLine(const Terminal& terminal, std::string_view what)
    : shown_(terminal.live && !terminal.quiet && progress_descriptor() < 0), language_(terminal.language), what_(what) {
  if (shown_) ticking_ = std::thread([this] { draw_until_ended(); });
}

Progress ProgressLine::progress() {
  if (!shown_ && progress_descriptor() < 0) return {};
  return [this](double done, std::string_view what) { note_done(done, what); };
}

void ProgressLine::note_done(double done, std::string_view what) {
  const std::lock_guard lock(mutex_);
  done_ = std::clamp(done, 0.0, 1.0);
  what_ = what;
  if (Clock::now() - drawn_at_ > std::chrono::milliseconds(100)) draw();
}

void ProgressLine::draw_until_ended() {
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, std::chrono::seconds(1), [this] { return ended_; })) draw();
}

void ProgressLine::draw() {
  drawn_at_ = Clock::now();
  if (const int descriptor = progress_descriptor(); descriptor >= 0) {
    const auto line = fmt::format("{:.4f} {}\n", done_, what_);
    [[maybe_unused]] const auto written = write(descriptor, line.data(), line.size());
    return;
  }
  drawn_ = true;
  constexpr int width = 30;
  const auto full = static_cast<int>(done_ * width);
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(drawn_at_ - begin_).count();
  put_message(fmt::format("\r\033[K[{:#<{}}{:.<{}}] {:3.0f} % {}{}", "", full, "", width - full, 100.0 * done_,
                          in_language(language_, Sentence(what_.c_str())),
                          seconds > 0 ? fmt::format(", {} s", seconds) : ""));
  std::fflush(stderr);
}

ProgressLine::~ProgressLine() {
  if (!shown_) return;
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  ticking_.join();
  if (!drawn_) return;
  put_message("\r\033[K");
  std::fflush(stderr);
}

}  // namespace tumble::cli
