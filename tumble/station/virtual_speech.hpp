#pragma once

#include "tumble/wire/controller.hpp"

namespace tumble {

/// What a virtual device wants to say, as this controller can say it: a word that the declaration does not have becomes
/// the nearest that it has ("running" for "moving"), and a word that a reply carries beside is that of a sound device.
ControllerReply in_words_of(const Controller& controller, ControllerReply reply);

}  // namespace tumble
