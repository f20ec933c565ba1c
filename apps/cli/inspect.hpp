#pragma once

#include <string>

#include "verbs.hpp"

namespace tumble::cli {

/// What `inspect --json` prints.
std::string inspection_json(const tumble::Inspection& inspection);

}  // namespace tumble::cli
