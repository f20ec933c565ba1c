#include "tumble/formats/dataflash/gps_time.hpp"

#include <cmath>

#include "tumble/core/instant.hpp"

namespace tumble::dataflash {
namespace {

constexpr std::int64_t begin_of_gps = 315'964'800;  ///< [s] since 1970-01-01: 1980-01-06
constexpr std::int64_t seconds_of_week = 604'800;
constexpr double fix_in_three_dimensions = 3.0;

/// GPS minus UTC [s] at a time of GPS [s]. Bulletin C of the IERS, 36 to 70.
std::int64_t leap_seconds(std::int64_t gps) {
  if (gps >= 1'167'264'018) return 18;    // 2017-01-01
  if (gps >= 1'119'744'017) return 17;    // 2015-07-01
  return gps >= 1'025'136'016 ? 16 : 15;  // 2012-07-01, 2009-01-01
}

}  // namespace

std::optional<std::int64_t> utc_of(double week, double milliseconds) {
  constexpr double last_week = 10'000.0;
  if (!(week > 0.0 && week < last_week && milliseconds >= 0.0 && milliseconds < 1e3 * seconds_of_week))
    return std::nullopt;
  const std::int64_t ms = std::llround(milliseconds);
  const std::int64_t gps = static_cast<std::int64_t>(week) * seconds_of_week + ms / 1000;
  return (begin_of_gps + gps - leap_seconds(gps)) * 1'000'000'000 + ms % 1000 * 1'000'000;
}

std::optional<std::int64_t> start_by_gps(const Description& description, const char* message) {
  const auto value = [&](const char* label) { return value_of(description, message, label); };
  // Older firmware: TimeMS is the time in the week, and T that since the start.
  const bool old = !value("GMS");
  const auto week = value(old ? "Week" : "GWk"), in_week = value(old ? "TimeMS" : "GMS"),
             since_start = value(old ? "T" : "TimeUS");
  if (!week || !in_week || !since_start || value("Status").value_or(fix_in_three_dimensions) < fix_in_three_dimensions)
    return std::nullopt;
  const double nanoseconds = *since_start * (old ? 1e6 : 1e3);
  const auto utc = utc_of(*week, *in_week);
  if (!utc || !is_set(*utc) || !(nanoseconds >= 0.0 && nanoseconds < 1e18)) return std::nullopt;
  return *utc - static_cast<std::int64_t>(nanoseconds);
}

}  // namespace tumble::dataflash
