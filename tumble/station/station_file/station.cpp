#include <algorithm>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/station/station_file.hpp"

namespace tumble {

bool StationDevice::can(const std::string& verb) const {
  return std::find(verbs.begin(), verbs.end(), verb) != verbs.end();
}

double silence_of(const StationInstrument& instrument) {
  if (instrument.lost_after > 0.0) return instrument.lost_after;
  return std::max(5.0, instrument.rate > 0.0 ? 20.0 / instrument.rate : 0.0);
}

Station load_station(const std::string& path) {
  const std::string text = read_text_file(path);
  return read_station(text, path);
}

}  // namespace tumble
