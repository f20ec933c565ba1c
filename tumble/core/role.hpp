#pragma once

#include <string>

namespace tumble {

/// A part that a channel plays in a method: "gyro", "reference".
struct Role {
  std::string name;
  std::string unit;  ///< dimension the channel must have, and the unit it is shown in
  bool required = true;
  std::string description;
  bool several = false;  ///< several channels may play it: see channels_for
};

}  // namespace tumble
