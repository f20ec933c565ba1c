#pragma once

#include <span>
#include <string>
#include <string_view>

namespace tumble {

/// The texts [N] in their order, with `between` between each two: "gyro_x, gyro_y". Empty without texts.
std::string joined(std::span<const std::string> texts, std::string_view between = ", ");

/// The part of the text without the blanks at its two ends. It points into `text`.
///
/// Given     blanks  the letters that count as blank
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

}  // namespace tumble
