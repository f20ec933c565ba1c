#pragma once

#include <string>
#include <string_view>

#include "tumble/core/text.hpp"

namespace tumble {

/// A name of a result as people read it: "angle_random_walk" becomes "angle random walk", "gyro.x.bias_instability"
/// becomes "gyro.x bias instability". Names of symbols (K_1, A1_0, D_OO) stay as they are: no part of them is a word of
/// three small letters or more.
std::string readable_name(std::string_view name);
/// Readable name in this language: "gyro.x 角度随机游走". A name that means something else in results of one method has a
/// text of its own, with the method before it. A name that [result] of text/<code>.toml lacks is readable as in
/// English.
std::string readable_name(Language language, std::string_view name, std::string_view method = {});

}  // namespace tumble
