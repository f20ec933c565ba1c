#pragma once

#include <string>
#include <vector>

#include "tumble/station/station_file.hpp"

namespace tumble::lease {

/// Names of a link of a station, which do not depend on how it is written: `tcp:127.0.0.1:5025` for each numeric
/// address of the host (one of IPv4 that is written as IPv6 is that of IPv4), `serial:4:64` by the numbers of the
/// device. A link that cannot be resolved keeps its text as its name.
std::vector<std::string> names_of_link(const std::string& link);

/// Names of the link of a device, and its serial number where the station says which one its answer to `identify`
/// contains ("SN 12", "S/N: 4711", "serial 8"): two addresses at which this number is expected of the same controller
/// are one device. Devices on this computer are played, and many may be played at once.
std::vector<std::string> names_of_device(const StationDevice& device);

}  // namespace tumble::lease
