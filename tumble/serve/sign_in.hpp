#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "tumble/serve/users_file.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {

/// Outcome of the check of a password.
struct PasswordCheck {
  enum class State { right, wrong, paused };
  State state = State::wrong;
  unsigned before = 0;     ///< right: wrong attempts since the last right one
  unsigned remaining = 0;  ///< wrong: attempts before a pause
  double pause = 0.0;      ///< [s] paused: until the next attempt counts
};

/// Who is signed in at a workbench. Users are those of a file, which is read again when it changes: who is removed from
/// it is out at once. Every member may be called from any thread.
class SignIn {
 public:
  /// `clock` [s] never runs backwards. Throws as read_users(), and Error::bad_input for a file without users.
  SignIn(std::string file, std::function<double()> clock);

  /// Compares; a user that is not there takes as long as one that is. After `free_attempts` wrong ones in a row a name
  /// waits, each time twice as long; while it waits even the right password is not looked at. Only one check is made at
  /// a time, since each takes much memory: others wait.
  PasswordCheck check(const std::string& user, const std::string& password);

  /// Begins a session; the secret of its cookie. Only after check() was right.
  std::string begin(const std::string& user);
  /// The session of a secret, with the roles that its user has now; none where it is unknown or too old.
  std::optional<Session> session_of(const std::string& secret);
  /// session_of() with the users as they are known: it waits for no disk, and hears of a change a second later.
  std::optional<Session> known_session_of(const std::string& secret);
  void end(const std::string& secret);

  static constexpr unsigned free_attempts = 5;
  static constexpr double first_pause = 30.0, longest_pause = 900.0;  ///< [s]
  static constexpr double longest_session = 12.0 * hour;              ///< [s]

 private:
  struct Attempts {
    unsigned wrong = 0;
    double last = 0.0, until = 0.0;  ///< [s] of the clock
  };
  struct Opened {
    std::string user, password;  ///< hash: a new password ends the sessions of the old one
    double begun = 0.0;
  };
  std::optional<Session> session_of(const std::string& secret, const UsersFile::Users& users);
  Attempts& attempts_of(const std::string& user);
  void forget_oldest_of(const std::string& user);

  UsersFile file_;
  std::function<double()> clock_;
  std::string decoy_;  ///< hash that is compared for users that are not there
  std::mutex mutex_, checking_;
  std::map<std::string, Attempts> attempts_;  ///< by SHA-256 of the name
  double forgotten_ = 0.0;                    ///< [s] when old ones were looked for
  std::map<std::string, Opened> sessions_;    ///< by SHA-256 of their secret
};

}  // namespace tumble
