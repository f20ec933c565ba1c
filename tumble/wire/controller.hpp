#pragma once

#include <map>
#include <string>

namespace tumble {

/// What a station wants of a rig, a chamber or a supply. Values are SI: {"position", rad}.
struct ControllerRequest {
  std::string verb;
  std::map<std::string, double> values = {};
  int axis = 1;
};

/// What a controller said. Only a reply without `problem` and without `refused` carries values.
struct ControllerReply {
  std::string verb;                               ///< of the request
  std::map<std::string, double> values = {};      ///< [SI]
  std::map<std::string, std::string> words = {};  ///< {"state", "moving"}
  bool refused = false;                           ///< the controller understood and said no
  std::string text = {};                          ///< why
  std::string problem = {};                       ///< not empty: bytes that are no answer
  int axis = 1;
};

}  // namespace tumble
