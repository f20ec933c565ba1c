#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tumble/core/finding.hpp"

namespace tumble::topics {

/// Damage of a file whose messages follow one another.
struct Damage {
  std::size_t stretches = 0;  ///< that are no messages
  std::size_t bytes = 0;      ///< in them
  std::size_t first = 0;      ///< [bytes] where the first begins
  std::size_t cut_off = 0;    ///< [bytes] of a message at the end of the file
  std::size_t undescribed =
      0;  ///< messages, or places where one may begin, whose id or format the file does not describe
};

/// Findings about it. Given: unreadable, the names of messages whose description cannot be used.
void name_damage(const Damage& damage, const std::vector<std::string>& unreadable, Findings& findings);

}  // namespace tumble::topics
