#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/checks/support/grain.hpp"
#include "tumble/checks/support/signals.hpp"
#include "tumble/checks/support/texture.hpp"
#include "tumble/math/median.hpp"

namespace tumble::checks::repeated_samples {

namespace {

using namespace support;

constexpr std::size_t part = 1024, most_parts = 64, least_part = 256, pieces = 32;
/// [1] of the samples that repeat the one before, between which their places tell: at 5 % the 32 pieces of a part hold
/// 1.6 of them each, and evenly placed ones scatter by a sixth of what chance does.
constexpr double fewest = 0.05, most = 0.97;
/// [1] of the variance by chance. Evenly placed repeats have at most 1/4 to 32 p (1 - p), less than 0.17; of 32 pieces
/// chance shows less than 0.25 once in 10^9 parts.
constexpr double evenly = 0.25;
/// [1] of the parts with repeats, that are like this.
constexpr double least_share = 0.5;
/// [steps] of the median change: a slow signal on a grid repeats evenly too, but it changes by one step at a time.
constexpr double beyond_grid = 3.0;

/// How the repeats are spread over a part.
struct Spread {
  double share = 0.0;  ///< of the samples that equal the one before
  double ratio = NAN;  ///< variance of their number in a piece, over that by chance; NaN: too few or too many
};

Spread spread_in(std::span<const double> x) {
  const std::size_t size = x.size() / pieces;
  double sum = 0.0, squares = 0.0, present = 0.0;
  for (std::size_t k = 0; k < pieces; ++k) {
    double repeats = 0.0;
    for (std::size_t i = std::max<std::size_t>(1, k * size); i < (k + 1) * size; ++i) {
      repeats += x[i] == x[i - 1] ? 1.0 : 0.0;
      present += std::isnan(x[i]) ? 0.0 : 1.0;
    }
    sum += repeats;
    squares += repeats * repeats;
  }
  Spread spread;
  if (present < 0.5 * static_cast<double>(x.size())) return spread;
  spread.share = sum / present;
  if (spread.share < fewest || spread.share > most) return spread;
  const double mean = sum / pieces, variance = (squares - pieces * mean * mean) / (pieces - 1.0);
  spread.ratio = variance / (static_cast<double>(size) * spread.share * (1.0 - spread.share));
  return spread;
}

/// Median size of the changes that are not zero [u].
double usual_change(std::span<const double> x) {
  std::vector<double> changes;
  for (std::size_t i = 1; i < x.size(); ++i)
    if (const double change = std::abs(x[i] - x[i - 1]); change > 0.0) changes.push_back(change);
  return changes.empty() ? 0.0 : median(std::move(changes));
}

/// Whether the values of a part move by more than the grid on which those of the channel lie.
bool beyond_steps(std::span<const double> x, bool counts, const Texture& texture, const Grain& grain) {
  if (texture.noisy && !counts) return true;
  return usual_change(x) > beyond_grid * (counts ? std::max(1.0, grain.smallest) : grain.smallest);
}

/// Parts of the values, each within one segment: what happens at rest is no measure of a motion.
std::vector<std::span<const double>> parts_of(const Channel& channel, const std::vector<Mark>& marks) {
  const std::span<const double> values = channel.values;
  std::vector<std::size_t> borders{0};
  for (const Mark& mark : marks) borders.push_back(std::min(index_at(channel, mark.begin), values.size()));
  borders.push_back(values.size());
  std::ranges::sort(borders);
  std::vector<std::span<const double>> parts;
  for (std::size_t b = 1; b < borders.size(); ++b)
    for (std::size_t first = borders[b - 1]; first + least_part <= borders[b]; first += part)
      parts.push_back(values.subspan(first, std::min(part, borders[b] - first)));
  const std::size_t stride = (parts.size() + most_parts - 1) / most_parts;
  std::vector<std::span<const double>> chosen;
  for (std::size_t k = 0; k < parts.size(); k += stride) chosen.push_back(parts[k]);
  return chosen;
}

Findings look_at(const Channel& channel, const std::vector<Mark>& marks) {
  const std::span<const double> values = channel.values;
  if (values.size() < least_part) return {};
  std::vector<double> shares, ratios;
  const bool counts = channel.kind == QuantityKind::count;
  const Texture texture = texture_of(values);
  const Grain grain = grain_of(values);
  for (const auto& stretch : parts_of(channel, marks)) {
    const Spread spread = spread_in(stretch);
    if (std::isnan(spread.ratio) || !beyond_steps(stretch, counts, texture, grain)) continue;
    shares.push_back(spread.share);
    ratios.push_back(spread.ratio);
  }
  const auto even = std::ranges::count_if(ratios, [](double ratio) { return ratio < evenly; });
  if (ratios.empty() || static_cast<double>(even) < least_share * static_cast<double>(ratios.size())) return {};
  const double share = median(std::move(shares)), rate = mean_rate(channel);
  return {{Finding::Severity::warning,
           "samples_repeat",
           {{"part", share, "%"}, {"rate", rate, "Hz"}, {"new_rate", rate * (1.0 - share), "Hz"}},
           channel.name}};
}

Findings run(const Recording& recording, const Plan* plan) {
  return findings_of_each(recording, [&](const Channel& channel) {
    return is_signal(channel, plan) ? look_at(channel, recording.marks) : Findings{};
  });
}

}  // namespace

extern const Check repeated_samples{"repeated_samples",
                                    "samples that repeat the one before at even intervals: a slower sensor", run};

}  // namespace tumble::checks::repeated_samples
