#pragma once

#include <cstdint>
#include <optional>

#include "tumble/formats/dataflash/messages.hpp"

namespace tumble::dataflash {

/// [ns] since 1970-01-01 UTC of a week of GPS [1] and the time in it [ms], with the leap seconds since 2009; nothing
/// where there is no such time.
std::optional<std::int64_t> utc_of(double week, double milliseconds);

/// [ns] since 1970-01-01 UTC at which the autopilot started, whose clock the log has, as the message GPS of a receiver
/// with a fix says; nothing where it has none.
std::optional<std::int64_t> start_by_gps(const Description& description, const char* message);

}  // namespace tumble::dataflash
