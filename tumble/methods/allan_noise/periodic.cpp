#include "tumble/methods/allan_noise/periodic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/spectrum/sines.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::allan_noise {
namespace {

/// [1] of the amplitude of a sine, from which on a line about it is the broader one; records in which noise makes one
/// sine with the power that a sine must have.
constexpr double broader_amplitude = 0.5, records_of_false_line = 1e4;

/// Power of an ordinate over that of the noise, from which on it may be a line: exceeded with p = e^-16 = 1e-7 and
/// e^-25 = 1e-11. A line of many periods is tried at more frequencies.
constexpr double power_of_few_periods = 16.0, power_of_many_periods = 25.0, many_periods = 100.0;

constexpr double fewest_periods = 5.0, least_power = 12.0, most_unsteady = 0.3, clear_wander = 4.0;
constexpr int most_rounds = 6;
constexpr std::size_t most_at_once = 8;

/// Expected mean squares of the bands.
std::vector<double> expected_of(const NoiseBands& bands, const NoiseFit& fit) {
  const auto white = expected_filtered(bands.bands, fit.filter);
  std::vector<double> expected;
  for (std::size_t b = 0; b < bands.bands.size(); ++b) {
    const NoiseBand& band = bands.bands[b];
    double sum = fit.ramp.kept ? fit.ramp.slope * fit.ramp.slope * band.ramp_square : 0.0;
    for (std::size_t t = 0; t < fit.terms.size(); ++t) {
      const FittedTerm& term = fit.terms[t];
      if (!term.kept) continue;
      sum += term.squared * (t == 1                     ? white[b]
                             : t < band.expected.size() ? band.expected[t]
                                                        : expected_markov(band, term.unit.markov_time));
    }
    expected.push_back(sum);
  }
  return expected;
}

/// Variance [u^2] of white noise of the density that the terms have at a frequency.
double level_at(double frequency, const NoiseBands& bands, const std::vector<double>& expected) {
  const auto away = [&](const NoiseBand& band) { return std::abs(std::log(band.frequency / frequency)); };
  std::size_t nearest = 0;
  for (std::size_t b = 1; b < bands.bands.size(); ++b)
    if (away(bands.bands[b]) < away(bands.bands[nearest])) nearest = b;
  return expected[nearest] / bands.bands[nearest].expected[1];
}

/// Slow sines far above their expectation, with the ratio for an amplitude: of noise, once in a hundred records.
std::vector<SpectralLine> slow_peaks(const NoiseBands& bands, const std::vector<double>& expected) {
  const double record = static_cast<double>(bands.samples);
  const auto& ordinates = bands.ordinates;
  const auto ratio = [&](std::size_t i) { return ordinates[i].square / expected[ordinates[i].band]; };
  std::vector<SpectralLine> peaks;
  for (std::size_t i = 0; i < ordinates.size(); ++i) {
    const double periods = ordinates[i].frequency * record, one = ratio(i);
    if (periods < fewest_periods || one < (periods < many_periods ? power_of_few_periods : power_of_many_periods))
      continue;
    bool highest = true;
    for (std::size_t j = i - std::min<std::size_t>(i, 4); j <= std::min(i + 4, ordinates.size() - 1); ++j)
      highest = highest && ratio(j) <= one;
    if (highest) peaks.push_back({ordinates[i].frequency, one, 2.0 / record});
  }
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const SpectralLine& a, const SpectralLine& b) { return a.amplitude > b.amplitude; });
  if (peaks.size() > most_at_once) peaks.resize(most_at_once);
  return peaks;
}

std::vector<SpectralLine> lines_of_means(std::span<const double> values) {
  constexpr std::size_t size = 16;
  std::vector<double> means;
  for (std::size_t first = 0; first + size <= values.size(); first += size) {
    double sum = 0.0;
    for (std::size_t i = first; i < first + size; ++i) sum += values[i] / size;
    means.push_back(sum);
  }
  auto lines = spectral_lines(means);
  for (auto& line : lines) {
    line.frequency /= size;
    line.width /= size;
  }
  return lines;
}

bool near(const SpectralLine& a, double frequency, double width) {
  return std::abs(a.frequency - frequency) <= a.width + width;
}

bool listed(const SpectralLine& line, const std::vector<SpectralLine>& in) {
  return std::any_of(in.begin(), in.end(),
                     [&](const SpectralLine& other) { return near(other, line.frequency, line.width); });
}

/// One line of what overlaps, of the largest amplitude and the width of all.
void merge(const SpectralLine& line, std::vector<SpectralLine>& into) {
  for (SpectralLine& other : into) {
    if (!near(other, line.frequency, line.width)) continue;
    const double low = std::min(other.frequency - other.width, line.frequency - line.width),
                 high = std::max(other.frequency + other.width, line.frequency + line.width);
    other = {0.5 * (low + high), std::max(other.amplitude, line.amplitude), 0.5 * (high - low)};
    return;
  }
  into.push_back(line);
}

/// The search in progress.
struct Search {
  Search(std::span<const double> values, const NoiseBands& of_record, const NoiseFit& fit_of_record,
         const NoiseLikelihoodOptions& how)
      : sines(values), bands(of_record), fit(fit_of_record), options(how), expected(expected_of(bands, fit)) {}

  Sines sines;
  NoiseBands bands;
  NoiseFit fit;
  const NoiseLikelihoodOptions& options;
  std::vector<double> expected;
  std::vector<SineQuality> quality;
  std::vector<SpectralLine> peaks;  ///< the peak from which each sine began
  std::vector<bool> certain;        ///< whether it then stood out of its neighbourhood
  std::vector<SpectralLine> wandering, dropped;
  std::vector<SpectralLine> remaining, remaining_slow;  ///< peaks in the residual, and in means of it

  double level(double frequency) const { return level_at(frequency, bands, expected); }

  SineQuality quality_of(std::size_t which) const {
    return sines.quality(which, [this](double frequency) { return level(frequency); });
  }

  void judge() {
    quality.clear();
    for (std::size_t i = 0; i < sines.all().size(); ++i) quality.push_back(quality_of(i));
  }

  void fit_rest() {
    bands = NoiseBands(sines.rest());
    fit = fit_noise(without_lines(bands, wandering), options);
    expected = expected_of(bands, fit);
  }

  /// With what the sines took given back.
  void fit_at_last() {
    sines.give_back(
        expected, [this](double frequency) { return level(frequency); }, bands);
    bands = without_lines(bands, wandering);
    fit = fit_noise(bands, options);
  }

  void remove(std::size_t which) {
    sines.remove(which);
    peaks.erase(peaks.begin() + static_cast<std::ptrdiff_t>(which));
    certain.erase(certain.begin() + static_cast<std::ptrdiff_t>(which));
  }

  bool known(const SpectralLine& line) const {
    for (std::size_t i = 0; i < quality.size(); ++i)
      if (quality[i].wander > clear_wander && near(line, sines.all()[i].frequency, peaks[i].width)) return true;
    return listed(line, wandering) || listed(line, dropped);
  }

  std::vector<SpectralLine> unknown(std::vector<SpectralLine> lines) const {
    std::erase_if(lines, [this](const SpectralLine& line) { return known(line); });
    return lines;
  }

  /// Whether sines were added.
  bool take(const std::vector<SpectralLine>& lines, bool sure) {
    bool added = false;
    for (auto line : lines) {
      if (sines.all().size() == most_fitted_lines) break;
      sines.add(line.frequency, line.width);
      const std::size_t last = sines.all().size() - 1;
      if (!sure) line.amplitude = std::abs(sines.all()[last].amplitude);
      if (!doubled(last) && quality_of(last).power > least_power) {
        peaks.push_back(line);
        certain.push_back(sure);
        added = true;
      } else {
        sines.remove(last);
        merge(line, sure ? wandering : dropped);
      }
    }
    return added;
  }

  /// Whether a stronger one, or one before, lies so near that the record hardly separates the two: together they
  /// would be one of changing amplitude.
  bool doubled(std::size_t which) const {
    const double nearest = 4.0 / static_cast<double>(sines.rest().size());
    const Sine& sine = sines.all()[which];
    for (std::size_t i = 0; i < sines.all().size(); ++i) {
      const Sine& other = sines.all()[i];
      const bool before = std::abs(other.amplitude) > std::abs(sine.amplitude) || i < which;
      if (i != which && before && std::abs(other.frequency - sine.frequency) < nearest) return true;
    }
    return false;
  }

  /// Whether lines that periodograms show were added.
  bool take_fast() {
    return take(unknown(spectral_lines(sines.rest())), true) || take(unknown(lines_of_means(sines.rest())), false);
  }

  /// Whether a periodogram still shows half as much about a sine: then it is a piece of something broader.
  bool piece(std::size_t which) const {
    const Sine& sine = sines.all()[which];
    const auto broader = [&](const SpectralLine& line) {
      return near(line, sine.frequency, line.width) && line.amplitude > broader_amplitude * std::abs(sine.amplitude);
    };
    return std::any_of(remaining.begin(), remaining.end(), broader) ||
           std::any_of(remaining_slow.begin(), remaining_slow.end(), broader);
  }

  /// Puts back what is no line of its own beside the others.
  bool prune() {
    const double least = std::log(records_of_false_line * static_cast<double>(sines.rest().size()));
    bool pruned = false;
    for (std::size_t i = sines.all().size(); i-- > 0;) {
      const bool unsteady =
          (quality[i].wander > clear_wander && quality[i].unsteadiness > most_unsteady) || piece(i) || doubled(i);
      if (quality[i].power >= least && !unsteady) continue;
      merge(peaks[i], unsteady || certain[i] ? wandering : dropped);
      remove(i);
      pruned = true;
    }
    return pruned;
  }

  void settle(bool fast) {
    do {
      sines.refine();
      fit_rest();
      judge();
      if (fast) remaining = spectral_lines(sines.rest());
      if (fast) remaining_slow = lines_of_means(sines.rest());
    } while (prune());
  }

  void run(bool fast) {
    for (int round = 0; round < most_rounds; ++round) {
      bool added = false;
      for (int more = 0; fast && more < most_rounds && take_fast(); ++more) {
        sines.refine();
        added = true;
      }
      if (added) settle(fast);
      if (!take(unknown(slow_peaks(bands, expected)), false)) return;
      settle(fast);
    }
  }
};

FittedLine line_of(const Sine& sine, const SineQuality& quality) {
  // A departure from a sine along the record widens both.
  const double wider = std::sqrt(std::max(1.0, quality.wander > clear_wander ? quality.wander : 1.0));
  return {sine.frequency, quality.frequency_sd * wider, std::abs(sine.amplitude), quality.amplitude_sd * wider,
          quality.wander > clear_wander ? quality.unsteadiness : 0.0};
}

/// With as many decimals as show two digits of the uncertainty.
std::string rounded(double value, double sd) {
  return fmt::format("{:.{}f}", value, std::clamp(1 - static_cast<int>(std::floor(std::log10(sd))), 0, 15));
}

}  // namespace

PeriodicFit fit_beside_lines(std::span<const double> values, const NoiseBands& bands, const NoiseFit& fit,
                             const NoiseLikelihoodOptions& options) {
  const bool fast = fit.model_error > 0.0;
  const bool any = !slow_peaks(bands, expected_of(bands, fit)).empty() ||
                   (fast && (!spectral_lines(values).empty() || !lines_of_means(values).empty()));
  PeriodicFit result{{}, {}, bands, fit};
  if (!any) return result;
  Search search(values, bands, fit, options);
  search.run(fast);
  // Peaks that remain above the noise: skirts of unsteady lines, lines beyond the greatest number.
  for (const auto& line : search.remaining) merge(line, search.wandering);
  if (search.sines.all().empty() && search.wandering.empty()) return result;
  search.fit_at_last();
  for (std::size_t i = 0; i < search.sines.all().size(); ++i)
    result.lines.push_back(line_of(search.sines.all()[i], search.quality[i]));
  std::stable_sort(result.lines.begin(), result.lines.end(),
                   [](const FittedLine& a, const FittedLine& b) { return a.amplitude > b.amplitude; });
  result.wandering = search.wandering;
  result.bands = search.bands;
  result.fit = search.fit;
  return result;
}

double allan_variance_of(const FittedLine& line, double factor) {
  const double x = pi * line.frequency, s = std::sin(x * factor);
  return std::pow(line.amplitude * s * s / (factor * std::sin(x)), 2);
}

namespace {

/// The averaging factor at which a line adds most to the Allan variance, and that variance [u^2].
struct GreatestPart {
  double factor = 1.0, variance = 0.0;
};

GreatestPart greatest_part(const FittedLine& line) {
  GreatestPart part;
  for (double m = 1.0; m <= std::max(1.0, std::ceil(0.5 / line.frequency)); ++m)
    if (allan_variance_of(line, m) > part.variance) part = {m, allan_variance_of(line, m)};
  return part;
}

}  // namespace

void describe_lines(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  struct Row {
    const ChannelNoise& channel;
    const FittedLine& line;
    Unit unit;            ///< of the channel, as shown
    double frequency_sd;  ///< [Hz]

    std::string text(double si) const { return fmt::format("{:.3g} {}", unit.difference_from_si(si), unit.text()); }
    double sd() const { return unit.difference_from_si(line.amplitude_sd); }
  };
  std::vector<Row> rows;
  for (const auto& channel : channels)
    for (const auto& line : channel.lines)
      rows.push_back({channel, line, Unit::parse(rate_unit(channel.kind)), line.frequency_sd * channel.rate});
  const auto frequency = [](const Row& r) { return rounded(r.line.frequency * r.channel.rate, r.frequency_sd); };
  const auto amplitude = [](const Row& r) {
    return rounded(r.unit.difference_from_si(r.line.amplitude), r.sd()) + " " + r.unit.text();
  };
  const auto steady = [](const Row& r) {
    return r.line.unsteadiness > 0.0 ? fmt::format("varies by {:.2g} %", 100.0 * r.line.unsteadiness) : "steady";
  };
  add_unless_empty(
      estimate.tables,
      tabulate("lines", "sines in the record, fitted with the noise and subtracted", rows,
               {{"channel", [](const Row& r) { return r.channel.label; }},
                {"frequency", "Hz", frequency},
                {"sd", "Hz", [](const Row& r) { return fmt::format("{:.2g}", r.frequency_sd); }},
                {"amplitude", amplitude},
                {"sd of it", [](const Row& r) { return fmt::format("{:.2g} {}", r.sd(), r.unit.text()); }},
                {"deviation at most", [](const Row& r) { return r.text(std::sqrt(greatest_part(r.line).variance)); }},
                {"at tau", [](const Row& r) { return say_seconds(greatest_part(r.line).factor / r.channel.rate); }},
                {"along the record", steady}}));
}

}  // namespace tumble::allan_noise
