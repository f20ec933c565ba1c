#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tumble/serve/users.hpp"

namespace tumble {

/// The users of a file, which is read again when it changes, by a thread of its own: a disk that does not answer keeps
/// nobody waiting for long.
class UsersFile {
 public:
  using Users = std::shared_ptr<const std::vector<User>>;

  /// Throws as read_users(), and Error::bad_input for a file without users.
  explicit UsersFile(const std::string& file);
  UsersFile(const UsersFile&) = delete;
  UsersFile& operator=(const UsersFile&) = delete;
  ~UsersFile();

  /// The users that the file has now: nobody where it cannot be read, which is safer than the users of before. Where
  /// the disk does not answer, those of before after two seconds, and at once until it does.
  Users now();
  /// The users that the file had a second ago, or when the disk answered last. Waits for nothing.
  Users known() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace tumble
