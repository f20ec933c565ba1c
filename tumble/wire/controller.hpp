#pragma once

#include <map>
#include <string>

namespace tumble {

/// What a station wants of a rig, a chamber or a supply. Values are SI: {"position", rad}. `position.2` is the position
/// of axis 2 in a command that carries several axes; `position` is that of `axis`.
struct ControllerRequest {
  std::string verb;
  std::map<std::string, double> values = {};
  int axis = 1;
};

/// What a controller said. Only a reply without `problem` and without `refused` carries values.
struct ControllerReply {
  std::string verb;                           ///< of the request; "notice": the controller spoke without being asked
  std::map<std::string, double> values = {};  ///< [SI]
  std::map<std::string, std::string> words = {};  ///< {"state", "moving"}
  bool refused = false;      ///< the controller understood and said no, or reads back another value
  std::string text = {};     ///< why; of a notice, the text
  std::string problem = {};  ///< not empty: bytes that are no answer; the request stays outstanding
  int axis = 1;
};

}  // namespace tumble
