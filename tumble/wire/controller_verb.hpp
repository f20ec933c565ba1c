#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/units/sentence.hpp"

namespace tumble {

/// The requests that a station can make of a controller. docs/formats/controllers.md says what each does.
enum class ControllerVerb {
  identify,
  take,
  release,
  enable,
  disable,
  home,
  rate,
  position,
  sine,
  stop,
  read,
  state,
  clear_fault,
  set_temperature,
  set_ramp,
  start,
  hold,
  off,
  resume,
  set_point,
  alarm,
  set_voltage,
  set_current,
  set_limits,
  sweep,
  random,
  notice  ///< of a reply alone: the controller spoke without being asked
};

/// "set_temperature": the word of declarations and station files.
const std::string& name(ControllerVerb verb);

/// The words of all verbs that a declaration may have, in the order of ControllerVerb.
const std::vector<std::string>& controller_verbs();

/// The verb that a person or a declaration names; absent where no verb has this word.
std::optional<ControllerVerb> find_verb(std::string_view word);

/// The refusal of a word that is no verb, with the nearest verb.
Sentence unknown_verb(const std::string& word);

}  // namespace tumble
