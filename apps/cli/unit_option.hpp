#pragma once

#include <string>

#include "tumble/tasks/tasks.hpp"

namespace tumble::cli {

/// What `--unit [SLOT=]SERIAL` says, as values of --set; an empty text says nothing.
///
/// Throws    Error::bad_input where the slot or the serial number is empty
Sets sets_of_unit(const std::string& text);

/// The serial number alone.
std::string serial_of_unit(const std::string& text);

}  // namespace tumble::cli
