#include <algorithm>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/station/station_file.hpp"

namespace tumble {

bool StationDevice::can(const std::string& verb) const {
  return std::find(verbs.begin(), verbs.end(), verb) != verbs.end();
}

Station load_station(const std::string& path) {
  const std::string text = read_text_file(path);
  return read_station(text, path);
}

}  // namespace tumble
