#pragma once

#include <vector>

#include "verbs.hpp"

namespace tumble::cli {

/// What shells complete of these verbs, and the manual page of them.
Verb completion_verb(const std::vector<Verb>& verbs);

}  // namespace tumble::cli
