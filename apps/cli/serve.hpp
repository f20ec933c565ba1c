#pragma once

#include "verbs.hpp"

namespace tumble::cli {

/// The workbench in a browser.
Verb serve_verb();

}  // namespace tumble::cli
