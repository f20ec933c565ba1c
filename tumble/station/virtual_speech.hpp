#pragma once

#include "tumble/wire/controller.hpp"

namespace tumble {

/// Reply of a virtual device in the words of this controller: a word that the declaration does not have becomes the
/// nearest that it has ("running" for "moving"), and a word that a reply carries in addition is that of a sound device.
ControllerReply in_words_of(const Controller& controller, ControllerReply reply);

/// Requests for each axis that a request is for. A line that carries all axes is for those of which a value says so
/// that the declaration sets for a verb (`set = {mode = 2}`: `mode.3` is 2), and which have the value of that verb
/// (`rate.3` for `rate`); a stop, enable or disable that names no axis is for all.
std::vector<ControllerRequest> axis_by_axis(const Controller& controller, const ControllerRequest& request);

}  // namespace tumble
