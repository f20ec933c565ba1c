#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/checks/grain.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/checks/support/signals.hpp"
#include "tumble/checks/support/texture.hpp"
#include "tumble/math/fourier.hpp"
#include "tumble/math/median.hpp"
#include "tumble/units/constants.hpp"

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

/// [median change] of a course that is steep: neighbours that both lie so far apart do not repeat by noise or by steps.
constexpr double steep = 20.0;
/// A steep course stands still for one sample where it turns back. It does not in the middle of a rise: so many, and this
/// share of the places of the rises, are values that were held.
constexpr std::size_t least_held = 5;
constexpr double least_held_share = 0.1;

/// Of the places of one phase of a pattern all repeat the one before, by chance with p = 0.7^60 = 5e-10; of every other phase
/// some do and some do not, so that the pattern is not that of a slow rate that is counted.
constexpr std::size_t least_places = 60;
constexpr std::size_t most_with_pattern = 4;             ///< parts of a record
constexpr std::size_t finer_by = 4;                      ///< frequencies in what the length of a part resolves
constexpr double least_beside = 0.1, most_beside = 0.7;  ///< [1] of the other places that repeat
constexpr std::size_t phases_beside = 4;
constexpr double slowest = 0.03, fastest = 0.5;  ///< [1/sample] of held values: each is held at most once more
/// [1] of the expected power of a pattern by chance: exp(-20) is 2e-9.
constexpr double pattern_power = 20.0;
/// [1] of the share of held samples, by which parts of a record agree: a slower sensor keeps its rate, while counts of a rate that
/// changes from segment to segment have some pattern in one part and another in the next.
constexpr double same_share = 0.03;
constexpr double narrower = 0.9, wider = 1.3;  ///< [1] of the share of held samples: the phase that only holds

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

/// Where a course rises or falls steeply, the samples that repeat the one before.
struct Held {
  std::size_t places = 0, held = 0;
};

Held held_in(std::span<const double> x, double usual) {
  Held all;
  const auto like = [&](double a, double b) {
    return a * b > 0.0 && std::min(std::abs(a), std::abs(b)) > steep * usual;
  };
  for (std::size_t i = 2; i + 1 < x.size(); ++i) {
    const double before = x[i - 1] - x[i - 2], here = x[i] - x[i - 1], after = x[i + 1] - x[i];
    if (!like(before, after)) continue;
    all.held += here == 0.0;
    all.places += here == 0.0 || like(here, after);
  }
  return all;
}

/// [1] of the samples that are held, where a steep course shows it; NaN: it does not.
double held_while_moving(std::span<const double> x) {
  const Held all = held_in(x, std::max(usual_change(x), 1.0));
  const double share = static_cast<double>(all.held) / static_cast<double>(std::max<std::size_t>(1, all.places));
  return all.held < least_held || share < least_held_share ? NAN : share;
}

/// The share of the samples that a slower sensor holds, by the pattern of the repeats: a value is held whenever the phase
/// of the slower clock passes it by. NaN: they have no such pattern.
double held_in_pattern(const std::vector<bool>& repeats, double frequency) {
  const double n = static_cast<double>(repeats.size());
  std::vector<double> changing;  // phases
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    const double turns = frequency * static_cast<double>(i);
    if (!repeats[i]) changing.push_back(turns - std::floor(turns));
  }
  if (changing.size() < 2) return NAN;
  std::ranges::sort(changing);
  double gap = changing.front() + 1.0 - changing.back(), ends = changing.front();
  for (std::size_t k = 1; k < changing.size(); ++k)
    if (const double one = changing[k] - changing[k - 1]; one > gap) gap = one, ends = changing[k];
  if (gap < narrower * frequency || gap > wider * frequency || gap * n < static_cast<double>(least_places)) return NAN;
  std::array<double, phases_beside> all{}, alike{};
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    const double turns = frequency * static_cast<double>(i) - ends, phase = turns - std::floor(turns);
    const auto bin = static_cast<std::size_t>(phases_beside * phase / (1.0 - gap));
    if (bin < phases_beside) all[bin] += 1.0, alike[bin] += repeats[i] ? 1.0 : 0.0;
  }
  for (std::size_t k = 0; k < phases_beside; ++k)
    if (alike[k] < least_beside * all[k] || alike[k] > most_beside * all[k]) return NAN;
  return gap;
}

/// [1/sample] At which the repeats of a part recur most clearly, to a quarter of what its length resolves; NaN: at none.
double clearest_frequency(const std::vector<bool>& repeats) {
  const double n = static_cast<double>(repeats.size());
  const double share = static_cast<double>(std::ranges::count(repeats, true)) / n;
  std::vector<double> padded(finer_by * repeats.size());
  for (std::size_t i = 0; i < repeats.size(); ++i) padded[i] = (repeats[i] ? 1.0 : 0.0) - share;
  std::vector<std::complex<double>> spectrum;
  real_transform(padded, spectrum);
  double most = pattern_power * n * share * (1.0 - share), best = NAN;
  for (std::size_t k = 0; k < spectrum.size(); ++k) {
    const double frequency = static_cast<double>(k) / static_cast<double>(padded.size()),
                 power = std::norm(spectrum[k]);
    if (frequency >= slowest && frequency < fastest && power > most) most = power, best = frequency;
  }
  return best;
}

double held_in_pattern(std::span<const double> x) {
  std::vector<bool> repeats;
  for (std::size_t i = 1; i < x.size(); ++i) repeats.push_back(x[i] == x[i - 1]);
  const double best = clearest_frequency(repeats);
  if (std::isnan(best)) return NAN;
  const double step = 1.0 / static_cast<double>(finer_by * repeats.size());
  constexpr int finer = 20;
  for (int k = -finer; k <= finer; ++k)
    if (const double held = held_in_pattern(repeats, best + step * k / finer); !std::isnan(held)) return held;
  return NAN;
}

Finding finding(const Channel& channel, double share) {
  const double rate = mean_rate(channel);
  return {Finding::Severity::warning,
          "samples_repeat",
          {{"part", share, "%"}, {"rate", rate, "Hz"}, {"new_rate", rate * (1.0 - share), "Hz"}},
          channel.name};
}

/// Counts repeat by chance too: what is held shows in a steep course, or by its pattern.
Findings held_counts(const Channel& channel) {
  const std::span<const double> values = channel.values;
  if (const double share = held_while_moving(values); !std::isnan(share)) return {finding(channel, share)};
  const std::size_t length = std::min(part, values.size());
  const std::size_t parts = std::clamp<std::size_t>(values.size() / length, 1, most_with_pattern);
  std::vector<double> shares;
  for (std::size_t k = 0; k < parts; ++k) {
    const auto part_of = values.subspan(parts == 1 ? 0 : k * (values.size() - length) / (parts - 1), length);
    const double share = held_in_pattern(part_of);
    if (std::isnan(share)) continue;
    const auto agrees = [&](double other) { return std::abs(other - share) < same_share * share; };
    if (parts == 1 || std::ranges::any_of(shares, agrees)) return {finding(channel, share)};
    shares.push_back(share);
  }
  return {};
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
  if (ratios.empty() || static_cast<double>(even) < least_share * static_cast<double>(ratios.size()))
    return counts ? held_counts(channel) : Findings{};
  return {finding(channel, median(std::move(shares)))};
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
