#pragma once

#include <string>
#include <vector>

namespace tumble::lease {

/// What a link of a station is, however it is written: `tcp:127.0.0.1:5025` for each numeric address of the host (one
/// of IPv4 that is written as IPv6 is that of IPv4), `serial:4:64` by the numbers of the device. What cannot be found
/// out is as it is written.
std::vector<std::string> names_of_link(const std::string& link);

}  // namespace tumble::lease
