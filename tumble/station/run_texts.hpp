#pragma once

#include <string>

#include "tumble/station/carry_out.hpp"

/// Texts about a run, which are the same on the terminal and in the browser.
namespace tumble {

/// An axis in the units of the field: "40 deg/s"; empty where there is nothing to say.
struct AxisTexts {
  std::string demanded, position, rate;
};
AxisTexts texts_of(const RunView::AxisView& axis);

/// Whether something happens so often that a log of the run need not show it: phases of every segment.
bool is_everyday(const std::string& kind, const std::string& text);

/// "1:02:03" of a time [s].
std::string hours_text(double seconds);

}  // namespace tumble
