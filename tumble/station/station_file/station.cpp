#include <algorithm>
#include <filesystem>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/confinement.hpp"
#include "tumble/station/station_file.hpp"
#include "tumble/wire/controllers.hpp"

namespace tumble {

bool StationDevice::can(ControllerVerb verb) const {
  return std::find(verbs.begin(), verbs.end(), verb) != verbs.end();
}

bool StationDevice::may_carry(ControllerVerb verb, const std::string& value) const {
  const auto found = takes.find(verb);
  return found == takes.end() || std::ranges::find(found->second, value) != found->second.end();
}

Controller controller_of_device(const StationDevice& device, const std::string& folder) {
  if (std::filesystem::path(device.controller).extension() != ".toml")
    return controller_of(find_controller(device.controller), device.settings);
  const std::string path = file_named_in(folder, device.controller);
  return read_controller(read_text_file(path), path, device.settings);
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
