#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/counts.hpp"

namespace tumble::checks::missed_windows {

namespace {

using namespace support;

constexpr std::size_t side = 12;  ///< windows looked at before and behind each
/// [counts] of a window whose multiples show: the rounding of two counts is then an eighth of a window.
constexpr double least_counts = 16.0;
/// [1] of the median, within which all neighbours but four lie. Chosen: quiet enough to distinguish 1 window from 2 by
/// five times this scatter; a doubling looks at windows in motion too, where a count of 1.5 windows may be rate.
constexpr double most_scatter = 0.1;
constexpr double rounding = 2.0;  ///< [counts] that rounding may move the counts of one window by, at both of its ends
/// Windows in one count. Chosen: a greater ratio is a damaged count and no late read.
constexpr double most_windows = 1000.0;
/// [1] of a window that holds two or more, below which a quiet neighbour lies: (1 + most_scatter)/1.5 = 0.733, rounded
/// up.
constexpr double neighbour_bound = 0.75;

/// Median of the windows about one, and how far all but four of them lie from it.
struct Neighbours {
  double median = 0.0, scatter = 0.0;
};

Neighbours neighbours_of(const std::vector<double>& values, std::size_t i) {
  std::array<double, 2 * side> near;
  for (std::size_t k = 0; k < side; ++k) {
    near[k] = values[i - side + k];
    near[side + k] = values[i + 1 + k];
  }
  if (!std::ranges::all_of(near, [](double v) { return std::isfinite(v); })) return {0.0, 0.0};
  std::ranges::sort(near);
  const double median = 0.5 * (near[side - 1] + near[side]);
  return {median, std::max(near[2 * side - 3] - median, median - near[2])};
}

/// Whether a window may hold twice what its neighbours do. Of any five neighbours one lies within a tenth of the
/// median, since at most four of all do not, and that is 1.1/1.5 of the window at most.
bool may_stand_out(const std::vector<double>& values, std::size_t i) {
  const double bound = neighbour_bound * std::abs(values[i]);
  for (const std::size_t k : {i - 1, i + 1, i - 2, i + 2, i - 3})
    if (!(std::abs(values[k]) > bound)) return true;
  return false;
}

/// Windows that hold k = 2, 3, ... times what their quiet neighbours hold: the card was read too late, and counted on.
struct Late {
  std::size_t windows = 0, missed = 0, first = 0;
  double times = 0.0;
};

Late late_reads(const Channel& channel) {
  Late late;
  const auto& values = channel.values;
  for (std::size_t i = side; i + side < values.size(); ++i) {
    if (!std::isfinite(values[i]) || !may_stand_out(values, i)) continue;
    const Neighbours near = neighbours_of(values, i);
    const double size = std::abs(near.median);
    if (!(size >= least_counts) || !(near.scatter <= most_scatter * size)) continue;
    const double times = values[i] / near.median, whole = std::round(times);
    const double departure = std::abs(values[i] - whole * near.median);
    if (whole < 2.0 || whole > most_windows || departure > whole * (near.scatter + rounding)) continue;
    if (late.windows++ == 0) late.first = i, late.times = whole;
    late.missed += static_cast<std::size_t>(whole) - 1;
  }
  return late;
}

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const Channel& channel : recording.channels) {
    if (!counts_pulses(channel) || !spread_of(channel).whole) continue;
    const Late late = late_reads(channel);
    if (late.windows == 0) continue;
    findings.push_back({Finding::Severity::warning,
                        "missed_windows",
                        {{"missed", late.missed}, {"times", std::lround(late.times)}},
                        channel.name,
                        {late.windows, channel.time(late.first)}});
  }
  return findings;
}

}  // namespace

extern const Check missed_windows{"missed_windows", "pulse counts that hold the pulses of several counting windows",
                                  run};

}  // namespace tumble::checks::missed_windows
