#pragma once

#include <string>
#include <string_view>

namespace tumble {

/// A name of a result as people read it: "angle_random_walk" becomes "angle random walk", "gyro.x.bias_instability"
/// becomes "gyro.x bias instability". Names of symbols (K_1, A1_0, D_OO) stay as
/// they are: no part of them is a word of three small letters or more.
std::string readable_name(std::string_view name);

}  // namespace tumble
