#include "password.hpp"

#include <termios.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "tumble/units/error.hpp"

namespace tumble::cli {
namespace {

/// The terminal shows nothing of what is typed while this lives.
class Unseen {
 public:
  Unseen() {
    known_ = tcgetattr(STDIN_FILENO, &before_) == 0;
    if (!known_) return;
    termios silent = before_;
    silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    tcsetattr(STDIN_FILENO, TCSAFLUSH, &silent);
  }
  ~Unseen() {
    if (known_) tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
  }
  Unseen(const Unseen&) = delete;
  Unseen& operator=(const Unseen&) = delete;

 private:
  termios before_{};
  bool known_ = false;
};

std::string one_line() {
  std::string line;
  if (!std::getline(std::cin, line)) throw Error(Error::Kind::bad_input, "a password is expected, in one line");
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line;
}

std::string asked(const std::string& question) {
  std::fputs(question.c_str(), stderr);
  const std::string line = one_line();
  std::fputs("\n", stderr);
  return line;
}

}  // namespace

std::string new_password(const std::string& user) {
  if (isatty(STDIN_FILENO) == 0) return one_line();
  const Unseen unseen;
  const std::string password = asked("password of " + user + ": ");
  if (asked("again: ") != password) throw Error(Error::Kind::bad_input, "the two passwords differ");
  return password;
}

}  // namespace tumble::cli
