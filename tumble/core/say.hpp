#pragma once

#include <cstddef>
#include <string>

namespace tumble {

/// A length of time for a sentence: "310 ms", "12.5 s", "86400 s".
std::string say_seconds(double seconds);
/// An instant on the recording's clock for a sentence: "812.4 s", to a millisecond.
std::string say_instant(double seconds);
/// "1 sample", "3 samples": the noun must take a plain s.
std::string say_count(std::size_t count, const std::string& noun);

}  // namespace tumble
