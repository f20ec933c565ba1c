#include "tumble/methods/sine_vibration/screened.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "tumble/reduce/vibration/windows.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::sine_vibration {
namespace {

using vibration::Series;

/// Outliers at one phase are a distorted tone: so many, with this length of their mean phasor. Random phases have it
/// with p = e^-(8 0.49) = 0.02 for eight.
constexpr std::size_t fewest_at_phase = 8;
constexpr double at_phase = 0.7;
constexpr int rounds_of_outliers = 8;

/// Whether these windows lie at one phase of the tone, or at two that are opposite: a distorted tone, no lost pulses.
bool at_one_phase(const Series& series, double frequency, const std::vector<std::size_t>& index) {
  if (index.size() < fewest_at_phase || frequency == 0.0) return false;
  std::complex<double> one = 0.0, two = 0.0;
  for (const std::size_t i : index) {
    const double phase = two_pi * std::fmod(frequency * series.time[i], 1.0);
    one += std::polar(1.0, phase);
    two += std::polar(1.0, 2.0 * phase);
  }
  return std::max(std::abs(one), std::abs(two)) > at_phase * static_cast<double>(index.size());
}

}  // namespace

Line screened(const Series& series, double pulse, const std::function<Line(const std::vector<double>&)>& fit,
              vibration::Outliers& skipped) {
  const double rounding = vibration::rounding_sd(series, pulse);
  const Line whole = fit(series.force);
  std::vector<double> values = series.force;
  Line line = whole;
  for (int round = 0; round < rounds_of_outliers; ++round) {
    const auto outliers = vibration::outliers_of(line.residual, rounding);
    if (outliers.index.empty()) break;
    skipped.index.insert(skipped.index.end(), outliers.index.begin(), outliers.index.end());
    skipped.sum += outliers.sum;
    for (const std::size_t i : outliers.index) values[i] = std::nan("");
    if (vibration::windows_of_outlier * skipped.index.size() > values.size() ||
        at_one_phase(series, whole.frequency, skipped.index)) {
      skipped = {};
      return whole;
    }
    line = fit(values);
  }
  std::ranges::sort(skipped.index);
  return line;
}

}  // namespace tumble::sine_vibration
