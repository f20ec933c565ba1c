#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "tumble/wire/frames.hpp"

/// How declarations write numbers.
namespace tumble::declaration {

/// The whole number at the begin of `text`, which it is removed from; absent where no digit stands, or it is above
/// `most`.
std::optional<int> take_whole(std::string_view& text, int most);

/// Sign, zeros, width and decimals at the begin of `text`, which they are removed from: "+09.4". Absent where a point
/// has no number behind it, or a number is above `most`.
std::optional<FrameFormat> take_format(std::string_view& text, int most);

/// Half a unit [1] of the last digit of a number as it is written: "2.019593e-5 rad" gives 5e-12, "12.50 deg" 0.005.
double half_of_last_digit(const std::string& text);

}  // namespace tumble::declaration
