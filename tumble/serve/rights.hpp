#pragma once

#include <set>
#include <string>
#include <vector>

namespace tumble {

/// Rights of a user. Who may operate or approve may also read; one who approves does not operate by that.
enum class Right { read, operate, approve };

std::string name(Right right);
const std::vector<Right>& all_rights();

/// Who asks, as the server knows it.
struct Session {
  std::string user;  ///< empty: whoever has the link
  std::set<Right> roles;

  bool may(Right right) const { return roles.contains(right) || (right == Right::read && !roles.empty()); }
};

}  // namespace tumble
