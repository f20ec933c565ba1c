#include "tumble/report/figure/ticks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tumble::figure {
namespace {

/// 1, 2 or 5 times a power of ten, at least `step`.
double round_step(double step) {
  const double decade = std::pow(10.0, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= step * (1.0 - 1e-9)) return factor * decade;
  return 10.0 * decade;
}

std::string with_minus(std::string text) { return text.starts_with('-') ? "−" + text.substr(1) : text; }

std::string plain(double value, int decimals) {
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  return with_minus(text.find_first_not_of("-0.") == std::string::npos ? "0" : text);
}

void label(Ticks& ticks, double step) {
  const double largest = std::max(std::abs(ticks.at.front()), std::abs(ticks.at.back()));
  if (largest >= 1e5 || largest < 1e-3) ticks.exponent = static_cast<int>(std::floor(std::log10(largest)));
  const double unit = std::pow(10.0, ticks.exponent);
  const int decimals = std::clamp(-static_cast<int>(std::floor(std::log10(step / unit) + 1e-9)), 0, 15);
  for (const double at : ticks.at) ticks.labels.push_back(plain(at / unit, decimals));
}

}  // namespace

double Ticks::place(double value) const {
  if (logarithmic) return (std::log(value) - std::log(lower)) / (std::log(upper) - std::log(lower));
  return (value - lower) / (upper - lower);
}

Ticks linear_ticks(double low, double high, int most) {
  if (!(high - low > 1e-13 * std::max(std::abs(low), std::abs(high)))) {
    const double room = low == 0.0 ? 1.0 : 0.05 * std::abs(low);
    low -= room, high += room;
  }
  const double room = 0.04 * (high - low);
  Ticks ticks;
  ticks.lower = low - room, ticks.upper = high + room;
  const double step = round_step((ticks.upper - ticks.lower) / most);
  for (double k = std::ceil(ticks.lower / step); k * step <= ticks.upper; ++k) ticks.at.push_back(k * step);
  if (!ticks.at.empty()) label(ticks, step);
  return ticks;
}

std::string power_of_ten(int exponent) {
  static const char* const raised[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent))) text += raised[digit - '0'];
  return text;
}

Ticks logarithmic_ticks(double low, double high, int most) {
  constexpr double least_ratio = 1.2, room = 1.15;
  if (!(high > least_ratio * low)) low /= least_ratio, high *= least_ratio;
  Ticks ticks;
  ticks.logarithmic = true;
  ticks.lower = low / room, ticks.upper = high * room;
  if (ticks.upper < 5.0 * ticks.lower) {
    Ticks even = linear_ticks(low, high, most);
    even.lower = std::min(ticks.lower, even.at.front()), even.upper = std::max(ticks.upper, even.at.back());
    even.logarithmic = true;
    return even;
  }
  const int first = static_cast<int>(std::floor(std::log10(ticks.lower)));
  const int last = static_cast<int>(std::floor(std::log10(ticks.upper)));
  const int decades = last - first + 1, apart = (decades + most - 1) / most;
  const bool in_powers = std::ceil(std::log10(ticks.lower)) < -2.0 || last > 4;
  const auto inside = [&](double value) { return value >= ticks.lower && value <= ticks.upper; };
  for (int k = first; k <= last; ++k)
    for (int factor = 1; factor < 10; ++factor) {
      const double at = factor * std::pow(10.0, k);
      if (!inside(at)) continue;
      const bool few = 3 * decades <= most && (factor == 2 || factor == 5);
      if ((factor == 1 && k % apart == 0) || few) {
        ticks.at.push_back(at);
        ticks.labels.push_back(!in_powers    ? fmt::format("{:.6g}", at)
                               : factor == 1 ? power_of_ten(k)
                                             : fmt::format("{}·{}", factor, power_of_ten(k)));
      } else if (decades <= most) {
        ticks.minor.push_back(at);
      }
    }
  return ticks;
}

}  // namespace tumble::figure
