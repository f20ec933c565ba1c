#include "tumble/methods/rlg_lock_in/small_counts.hpp"

#include <cmath>
#include <map>
#include <numeric>

namespace tumble::rlg_lock_in {
namespace {

/// Samples of zero, and beyond the edge of the band, that a segment shows. Of counts about zero those of one are as frequent as
/// all beyond them and more: that 32 have none of one in between has p below 1e-9.
constexpr std::size_t least_zeros = 8, least_beyond = 32;

/// How often each size of a count occurs in a segment [counts].
std::map<long long, std::size_t> sizes_in(const Point& point, int edges) {
  std::map<long long, std::size_t> sizes;
  for (const double beat : point.beats)
    if (std::isfinite(beat)) ++sizes[std::llabs(std::llround(beat * point.sample_step * edges))];
  return sizes;
}

/// The greatest number of which all sizes are multiples; 0: all are zero.
long long common_of(const std::map<long long, std::size_t>& sizes) {
  long long common = 0;
  for (const auto& [size, count] : sizes) common = std::gcd(common, size);
  return common;
}

}  // namespace

Findings small_counts_lost(const Sweep& sweep, int edges) {
  long long of_others = 0;
  for (const Point& point : sweep.points)
    if (!point.dithered) of_others = std::gcd(of_others, common_of(sizes_in(point, edges)));
  if (of_others != 1) return {};
  Findings findings;
  for (const Point& point : sweep.points) {
    if (!point.dithered) continue;
    const auto sizes = sizes_in(point, edges);
    const long long common = common_of(sizes);
    const auto zeros = sizes.find(0);
    if (common < 2 || zeros == sizes.end() || zeros->second < least_zeros) continue;
    std::size_t all = 0;
    for (const auto& [size, count] : sizes) all += count;
    if (all - zeros->second < least_beyond) continue;
    findings.push_back({Finding::Severity::warning,
                        "small_counts_lost",
                        {{"zeros", zeros->second}, {"edge", static_cast<double>(common), "pulse"}},
                        point.label});
  }
  return findings;
}

}  // namespace tumble::rlg_lock_in
