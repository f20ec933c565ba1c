#pragma once

#include <string>

#include "tumble/core/limit.hpp"

/// Values that results of before hold as texts for people. Such texts are read here and nowhere else.
namespace tumble::legacy {

/// "<= 0.02 deg/h", ">= 1 g", "1 g to 2 g". Throws Error::bad_input with what cannot be read.
Limit limit_of(const std::string& text);

}  // namespace tumble::legacy
