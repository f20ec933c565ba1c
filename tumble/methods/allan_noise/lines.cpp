#include "tumble/methods/allan_noise/lines.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "tumble/math/fourier.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::allan_noise {
namespace {

constexpr std::size_t shortest_segment = 64;  ///< samples; a shorter one has no room for a line and its neighbours
/// Segments that are wanted, and with which lines are looked for: the mean of fewer scatters by more than its half.
constexpr std::size_t wanted_segments = 8;
constexpr double fewest_segments = 4.0;
/// Standard deviations of a mean ordinate, beyond which it may be a line: noise exceeds it with p = 1e-07 in the mean
/// of 4 segments, with 8e-11 in the mean of 16.
constexpr double threshold_sd = 10.0;
constexpr double same_line = 8.0;        ///< [bins] beside a line, and its width, that belong to it
constexpr double sines_gathered = 0.03;  ///< [1] of the frequency of a band of sines, that it reaches to both sides
/// [sd] of the mean square of a part, from which on it differs from the others; p = 6e-7 for each.
constexpr double part_differs = 5.0;
constexpr double change_is_warning = 0.1;  ///< [1] of the deviation. Chosen: less than what most budgets have for noise

constexpr std::size_t longest_segment = 4096, most_averaged = 512, most_lines = 8, neighbours = 24;
constexpr std::size_t lowest = 8;  ///< first frequency: below, a line and a slow drift cannot be distinguished
constexpr std::size_t spread = 2;  ///< half-width of a line under the window

struct Periodogram {
  std::vector<double> density;  ///< one-sided [u^2 samples], from frequency zero on
  double segments = 0.0;
  std::vector<double> images;  ///< of the missing values: at k, of a line k away [its density]; empty: none is missing
};

/// The power that the pattern of present values has beside its mean, over that of the mean.
class ImagesOfGaps {
 public:
  explicit ImagesOfGaps(const std::vector<double>& window) : window_(window), power_(window.size() / 2 + 1, 0.0) {}

  void add(std::span<const double> part) {
    double present = 0.0, whole = 0.0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      present += std::isnan(part[i]) ? 0.0 : window_[i];
      whole += window_[i];
    }
    mean_ += present * present;
    if (present == whole) return;
    missing_ = true;
    std::vector<double> pattern(part.size());
    for (std::size_t i = 0; i < part.size(); ++i)
      pattern[i] = window_[i] * ((std::isnan(part[i]) ? 0.0 : 1.0) - present / whole);
    real_transform(pattern, spectrum_);
    for (std::size_t k = 0; k < power_.size(); ++k) power_[k] += std::norm(spectrum_[k]);
  }

  std::vector<double> share() const {
    if (!missing_) return {};
    std::vector<double> share = power_;
    for (double& one : share) one /= mean_;
    return share;
  }

 private:
  const std::vector<double>& window_;
  std::vector<double> power_;
  std::vector<std::complex<double>> spectrum_;
  double mean_ = 0.0;
  bool missing_ = false;
};

/// Missing values count as the mean of their segment; segments that miss half of the window's power are not used.
Periodogram periodogram(std::span<const double> values, std::size_t length) {
  std::vector<double> window(length), segment(length);
  double power = 0.0;
  for (std::size_t i = 0; i < length; ++i) {
    const double sine = std::sin(pi * (static_cast<double>(i) + 0.5) / static_cast<double>(length));
    window[i] = sine * sine;
    power += window[i] * window[i];
  }
  Periodogram result{std::vector<double>(length / 2 + 1, 0.0), 0.0, {}};
  ImagesOfGaps images(window);
  const std::size_t segments = values.size() / length, stride = (segments + most_averaged - 1) / most_averaged;
  std::vector<std::complex<double>> spectrum;
  for (std::size_t first = 0; (first + 1) * length <= values.size(); first += stride) {
    const auto part = values.subspan(first * length, length);
    double mean = 0.0, present = 0.0, shown = 0.0;
    for (std::size_t i = 0; i < length; ++i) {
      if (std::isnan(part[i])) continue;
      mean += part[i];
      shown += window[i] * window[i];
      ++present;
    }
    if (shown < 0.5 * power) continue;
    mean /= present;
    for (std::size_t i = 0; i < length; ++i) segment[i] = std::isnan(part[i]) ? 0.0 : window[i] * (part[i] - mean);
    real_transform(segment, spectrum);
    for (std::size_t k = 0; k < result.density.size(); ++k) result.density[k] += 2.0 * std::norm(spectrum[k]) / shown;
    ++result.segments;
    images.add(part);
  }
  result.images = images.share();
  for (double& density : result.density) density /= std::max(1.0, result.segments);
  return result;
}

double median_of(std::span<const double> density) {
  std::vector<double> part(density.begin(), density.end());
  std::nth_element(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(part.size() / 2), part.end());
  return part[part.size() / 2];
}

/// Density without a line: geometric mean of the medians on either side, at equal distances on a logarithmic scale of
/// frequency, so that the slope of a walk or of flicker cancels.
double level_about(std::span<const double> density, std::size_t k) {
  const std::size_t low = std::max(k / 2, k - std::min(k, neighbours)),
                    high = std::min({density.size() - 1, 2 * k, k + neighbours});
  const std::span<const double> below = density.subspan(low, k - spread - low);
  if (high <= k + spread + 1) return median_of(below);
  return std::sqrt(median_of(below) * median_of(density.subspan(k + spread + 1, high - k - spread)));
}

/// Whether a peak may be what the missing values make of a stronger line.
bool is_image(const Periodogram& spectrum, std::size_t peak, std::size_t line) {
  constexpr double doubt = 4.0;  // either may lie between two frequencies of the transform
  if (spectrum.images.empty()) return false;
  const std::size_t length = 2 * (spectrum.images.size() - 1);
  const auto strongest = [&](std::size_t away) {
    if (away > length / 2) away = length - away;
    double most = 0.0;
    for (std::size_t k = away - std::min<std::size_t>(away, 1); k <= std::min(away + 1, length / 2); ++k)
      most = std::max(most, spectrum.images[k]);
    return most;
  };
  const double share = std::max(strongest(peak > line ? peak - line : line - peak), strongest(peak + line));
  return spectrum.density[peak] < doubt * share * spectrum.density[line];
}

}  // namespace

std::vector<SpectralLine> spectral_lines(std::span<const double> values) {
  std::size_t length = longest_segment;
  while (length > shortest_segment && values.size() / length < wanted_segments) length /= 2;
  const Periodogram spectrum = periodogram(values, length);
  std::vector<SpectralLine> lines;
  if (spectrum.segments < fewest_segments) return lines;
  const double threshold = 1.0 + threshold_sd / std::sqrt(spectrum.segments), bin = 1.0 / static_cast<double>(length);
  const auto& density = spectrum.density;
  // Beyond half the rate the density is what it is as far below.
  const auto mirrored = [&](std::size_t k) { return density[std::min(k, 2 * (density.size() - 1) - k)]; };
  for (std::size_t k = lowest; k < density.size(); ++k) {
    if (density[k] < density[k - 1] || density[k] <= mirrored(k + 1)) continue;
    const double base = level_about(density, k);
    if (density[k] < threshold * base) continue;
    double power = 0.0;
    for (std::size_t j = k - spread; j <= k + spread; ++j) power += (mirrored(j) - base) * bin;
    lines.push_back({static_cast<double>(k) * bin, std::sqrt(2.0 * std::max(0.0, power)), 2.0 * bin});
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const SpectralLine& a, const SpectralLine& b) { return a.amplitude > b.amplitude; });
  // A line that drifts has several peaks: one, with the amplitude of the highest and the width of all.
  std::vector<SpectralLine> separate;
  const auto number = [&](const SpectralLine& line) {
    return static_cast<std::size_t>(std::lround(line.frequency / bin));
  };
  for (const auto& line : lines) {
    const auto near = std::find_if(separate.begin(), separate.end(), [&](const SpectralLine& other) {
      return std::abs(other.frequency - line.frequency) < same_line * bin + other.width;
    });
    if (near != separate.end())
      near->width = std::max(near->width, std::abs(near->frequency - line.frequency) + line.width);
    else if (std::any_of(separate.begin(), separate.end(),
                         [&](const SpectralLine& other) { return is_image(spectrum, number(line), number(other)); }))
      continue;
    else if (separate.size() < most_lines)
      separate.push_back(line);
  }
  return separate;
}

NoiseBands without_lines(const NoiseBands& bands, const std::vector<SpectralLine>& lines) {
  NoiseBands remaining = bands;
  std::erase_if(remaining.bands, [&](const NoiseBand& band) {
    // A cosine within p values takes in what lies within 1/p of its frequency; sines are sharp but gathered 3 % wide.
    const double width = band.radix > 0 ? 1.0 / (band.radix * band.unit) : sines_gathered * band.frequency;
    return std::any_of(lines.begin(), lines.end(), [&](const SpectralLine& line) {
      return std::abs(line.frequency - band.frequency) < width + line.width;
    });
  });
  return remaining;
}

namespace {

/// Relative variance of the mean square over one of the parts, as neighbouring stretches of the record differ: of noise
/// whose contrasts are not alike (quantization, a filter) more than their number says. 0: unknown.
double variance_along(const NoiseBands& bands) {
  constexpr std::size_t stretches = 128;
  if (bands.scatter.empty() || bands.scatter[0]->bands.empty()) return 0.0;
  const PowerScatter& fast = *bands.scatter[0];
  if (fast.bands[0].unit != 1.0 || fast.groups.size() < stretches) return 0.0;
  std::vector<double> powers;
  for (std::size_t k = 0; k < stretches; ++k) {
    double square = 0.0, contrasts = 0.0;
    for (std::size_t g = fast.groups.size() * k / stretches; g < fast.groups.size() * (k + 1) / stretches; ++g) {
      contrasts += fast.groups[g].contrasts;
      for (const NoiseBand& band : fast.bands) square += fast.groups[g].square[static_cast<std::size_t>(band.order)];
    }
    if (contrasts > 0.0) powers.push_back(square / contrasts);
  }
  double sum = 0.0, differences = 0.0;
  for (std::size_t k = 0; k < powers.size(); ++k) {
    sum += powers[k];
    if (k > 0) differences += std::pow(powers[k] - powers[k - 1], 2);
  }
  if (powers.size() < stretches / 2 || !(sum > 0.0)) return 0.0;
  const auto count = static_cast<double>(powers.size()), mean = sum / count;
  return 0.5 * differences / (count - 1.0) / (mean * mean) * NoiseBands::parts / count;
}

}  // namespace

Findings changes_along(const NoiseBands& bands, double begin, double rate, const std::string& label) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < bands.part_count.size(); ++i) {
    sum += bands.part_count[i] * bands.part_mean_square[i];
    count += bands.part_count[i];
  }
  if (!(sum > 0.0)) return {};
  const double along = variance_along(bands);
  double most = 0.0;
  std::size_t part = 0;
  for (std::size_t i = 0; i < bands.part_count.size(); ++i) {
    const double off =
        std::abs(bands.part_mean_square[i] * count / sum - 1.0) / std::sqrt(std::max(along, 2.0 / bands.part_count[i]));
    if (off > most) {
      most = off;
      part = i;
    }
  }
  if (most < part_differs) return {};
  const double change = std::sqrt(bands.part_mean_square[part] * count / sum) - 1.0;
  const double length = static_cast<double>(bands.samples) / rate / NoiseBands::parts;
  return {{std::abs(change) > change_is_warning ? Finding::Severity::warning : Finding::Severity::info,
           "noise_changes_along_record",
           {{"change", change, "%"},
            {"from", begin + length * static_cast<double>(part), "s"},
            {"to", begin + length * static_cast<double>(part + 1), "s"},
            {"deviations", most}},
           label}};
}

}  // namespace tumble::allan_noise
