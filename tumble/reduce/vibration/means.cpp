#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::vibration {

namespace {

constexpr double same_value = 1e-5;    ///< [1] within which the values of two findings are one: six digits are shown
constexpr double same_gravity = 1e-3;  ///< [g] between two rests: a fixture that was turned shows more

bool equal(const FindingValue& a, const FindingValue& b) {
  if (a.name != b.name || a.value.index() != b.value.index()) return false;
  if (const auto* x = std::get_if<double>(&a.value)) {
    const double y = std::get<double>(b.value);
    return *x == y || std::abs(*x - y) <= same_value * std::max(std::abs(*x), std::abs(y));
  }
  if (const auto* phrase = std::get_if<Phrase>(&a.value)) return phrase->key == std::get<Phrase>(b.value).key;
  if (const auto* text = std::get_if<std::string>(&a.value)) return *text == std::get<std::string>(b.value);
  return std::get<long long>(a.value) == std::get<long long>(b.value);
}

}  // namespace

bool same_matter(const Finding& a, const Finding& b) {
  return a.code == b.code && std::ranges::equal(a.values, b.values, equal);
}

void add_once(Finding finding, Findings& findings) {
  const auto alike = [&](const Finding& f) { return same_matter(f, finding) && f.where == finding.where; };
  if (std::ranges::none_of(findings, alike)) findings.push_back(std::move(finding));
}

std::string place_of(const Data& data, const Series& series) {
  const auto& unit = data.units[series.unit];
  return unit.prefix.empty() ? series.label : unit.name + ", " + series.label;
}

double spread(const std::vector<double>& values) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const double v : values)
    if (!std::isnan(v)) ++n, sum += v;
  for (const double v : values)
    if (!std::isnan(v)) squares += (v - sum / n) * (v - sum / n);
  return std::sqrt(squares / n);
}

double sinc(double x) { return x == 0.0 ? 1.0 : std::sin(pi * x) / (pi * x); }

double three_digits(double frequency) { return rounded_to_digits(frequency, 3); }

double raster(double cycles_per_window, double pulses_per_window, double samples) {
  const auto off = [](double turns) { return std::abs(turns - std::round(turns)); };
  for (double p = 1.0; p < raster_within * samples; ++p)
    if (off(p * cycles_per_window) * samples < 1.0 && off(p * pulses_per_window) * samples < p) return p;
  return samples;
}

double rounding_log_variance(double amplitude, double cycles_per_window, double pulses_per_window, double samples) {
  const double p = raster(cycles_per_window, pulses_per_window, samples);
  if (p >= raster_within * samples) return 0.0;
  return 2.0 / (3.0 * p) * std::pow(std::sin(pi * cycles_per_window), 2) / (amplitude * amplitude);
}

Mean mean_of(const Series& series, double pulse) {
  constexpr std::size_t blocks = 16;
  Mean mean;
  double total = 0.0;
  std::vector<double> sum(blocks, 0.0), count(blocks, 0.0);
  for (std::size_t i = 0; i < series.force.size(); ++i) {
    if (std::isnan(series.force[i])) continue;
    const std::size_t b = i * blocks / series.force.size();
    sum[b] += series.force[i];
    ++count[b];
    total += series.force[i];
    ++mean.windows;
  }
  if (mean.windows == 0) return mean;
  const double n = static_cast<double>(mean.windows);
  mean.value = total / n;
  const double time = n * series.window;
  const double rounding = pulses::rounding_variance(pulse, time);
  double squares = 0.0, used = 0.0, rounding_of_blocks = 0.0;
  for (std::size_t b = 0; b < blocks; ++b) {
    if (count[b] == 0.0) continue;
    const double difference = sum[b] / count[b] - mean.value;
    squares += count[b] * difference * difference;
    rounding_of_blocks += count[b] * pulses::rounding_variance(pulse, count[b] * series.window);
    ++used;
  }
  mean.degrees_of_freedom = std::max(1.0, used - 1.0);
  const double white = used > 1.0 ? std::max(0.0, squares - rounding_of_blocks) / (used - 1.0) / n : 0.0;
  mean.variance = white + rounding;
  return mean;
}

bool is_same_rest(const Series& a, const Series& b) {
  return !(std::abs(a.rest - b.rest) > same_gravity * standard_gravity);
}

AtRest at_rest(const Data& data, const Series& series) {
  std::size_t before = data.series.size(), after = data.series.size();
  for (std::size_t i = 0; i < data.series.size(); ++i) {
    const Series& other = data.series[i];
    if (!other.at_rest() || other.unit != series.unit || other.power_up != series.power_up) continue;
    // A fixture that was turned in between shows another gravity.
    if (!is_same_rest(other, series)) continue;
    const auto nearer = [&](std::size_t nearest) {
      return nearest == data.series.size() ||
             std::abs(other.middle() - series.middle()) < std::abs(data.series[nearest].middle() - series.middle());
    };
    std::size_t& side = other.middle() <= series.middle() ? before : after;
    if (nearer(side)) side = i;
  }
  const bool earlier = before < data.series.size(), later = after < data.series.size();
  if (!earlier && !later) return {};
  if (!(earlier && later)) return {{{earlier ? before : after, 1.0}}, false};
  const double a = data.series[before].middle(), b = data.series[after].middle();
  const double w = (series.middle() - a) / (b - a);
  return {{{before, 1.0 - w}, {after, w}}, true};
}

}  // namespace tumble::vibration
