#include <fmt/format.h>

#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/core/say.hpp"
#include "tumble/math/extremes.hpp"

namespace tumble::checks {

namespace {

using namespace support;

bool complete(const std::vector<double>& values) {
  const Extremes extremes = extremes_of(values);
  return extremes.present == values.size() && std::isfinite(extremes.lowest) && std::isfinite(extremes.highest);
}

Findings look_at(const Channel& channel) {
  if (complete(channel.values)) return {};
  const std::size_t size = channel.values.size();
  std::size_t missing = 0, run = 0, longest = 0, longest_begin = 0;
  for (std::size_t i = 0; i < size; ++i) {
    run = std::isfinite(channel.values[i]) ? 0 : run + 1;
    missing += run > 0;
    if (run > longest) longest = run, longest_begin = i + 1 - run;
  }
  if (missing == size)
    return {{Finding::Severity::error, size == 0 ? "no samples" : "every sample is missing", channel.name}};
  return {{2 * missing > size ? Finding::Severity::error : Finding::Severity::warning,
           fmt::format("{} of {} samples missing ({:.2g} %), the most in a row {} from {}", missing, size,
                       100.0 * static_cast<double>(missing) / static_cast<double>(size), longest,
                       say_instant(channel.time(longest_begin))),
           channel.name}};
}

Findings run(const Recording& recording, const Plan*) { return findings_of_each(recording, look_at); }

}  // namespace

extern const Check missing_samples{"missing_samples", "blank, NaN or infinite samples", run};

}  // namespace tumble::checks
