#include <algorithm>
#include <cmath>

#include "tumble/methods/random_vibration/describe.hpp"

namespace tumble::random_vibration {
namespace {

using vibration::Series;

constexpr std::size_t blocks_of_rest = 16, fewest_in_block = 8;  ///< of a rest, and windows of each
/// [sd of a window] by which the means of the blocks scatter about a straight line. Noise that is far slower than a window
/// passes it nowhere near a vibration: chosen, since the line between two rests is then no better known than by one window.
constexpr double wanders_by = 1.0;

struct RestBlock {
  double time = 0.0, mean = 0.0, squares = 0.0, count = 0.0;
};

std::vector<RestBlock> blocks_of(const Series& series) {
  std::vector<RestBlock> out(blocks_of_rest);
  const std::size_t length = series.force.size() / blocks_of_rest;
  for (std::size_t b = 0; b < blocks_of_rest; ++b) {
    RestBlock& block = out[b];
    for (std::size_t j = b * length; j < (b + 1) * length; ++j) {
      if (!std::isfinite(series.force[j])) continue;
      const double off = series.force[j] - block.mean;
      block.mean += off / ++block.count;
      block.squares += off * (series.force[j] - block.mean);
      block.time += (series.time[j] - block.time) / block.count;
    }
  }
  std::erase_if(out, [](const RestBlock& block) { return block.count < static_cast<double>(fewest_in_block); });
  return out;
}

/// Scatter of the means about a straight line through them.
double scatter_about_line(const std::vector<RestBlock>& all) {
  const auto n = static_cast<double>(all.size());
  double time = 0.0, mean = 0.0, tt = 0.0, ty = 0.0, yy = 0.0;
  for (const RestBlock& block : all) time += block.time / n, mean += block.mean / n;
  for (const RestBlock& block : all) {
    const double t = block.time - time, y = block.mean - mean;
    tt += t * t, ty += t * y, yy += y * y;
  }
  return std::sqrt(std::max(0.0, yy - ty * ty / tt) / (n - 2.0));
}

}  // namespace

void report_wander(const vibration::Data& data, Findings& findings) {
  for (const Series& series : data.series) {
    if (!series.at_rest()) continue;
    const auto all = blocks_of(series);
    if (all.size() < blocks_of_rest) continue;
    double squares = 0.0, freedom = 0.0;
    for (const RestBlock& block : all) squares += block.squares, freedom += block.count - 1.0;
    const double noise =
        std::max(std::sqrt(squares / freedom), vibration::rounding_sd(series, data.units[series.unit].pulse));
    const double wander = scatter_about_line(all);
    if (wander > wanders_by * noise)
      findings.push_back({Finding::Severity::warning,
                          "rest_wanders",
                          {{"wander", wander, "mg"}, {"times", wander / noise}},
                          place_of(data, series)});
  }
}

}  // namespace tumble::random_vibration
