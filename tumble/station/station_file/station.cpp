#include <algorithm>

#include "tumble/station/station_file.hpp"

namespace tumble {

bool StationDevice::can(const std::string& verb) const {
  return std::find(verbs.begin(), verbs.end(), verb) != verbs.end();
}

}  // namespace tumble
