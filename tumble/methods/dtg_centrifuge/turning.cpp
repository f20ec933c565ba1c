#include "tumble/methods/dtg_centrifuge/turning.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tumble/math/normal.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::dtg_centrifuge {
namespace {

/// A rate departs from the median of its level: [1] of it, a twentieth of what rates_do_not_settle refuses, [sd] of the readings,
/// and [deg/s] at rest.
constexpr double departs_share = 1e-3, departs_sd = 8.0, departs_at_rest = 0.01;
constexpr std::size_t even_in_succession = 3;  ///< samples, from which on the turning is even
constexpr std::size_t fewest_readings = 64;    ///< of a level
constexpr double least_remaining = 0.5;        ///< [1] of a level

/// Rates between neighbouring readings [rad/s] from `first` on; NaN: missing. A reading that begins anew every turn is that of
/// the turn which the planned rate makes likely.
std::vector<double> rates_between(const Channel& encoder, std::size_t first, std::size_t last, double planned) {
  std::vector<double> rates;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double time = encoder.time(i) - encoder.time(i - 1), turned = encoder.values[i] - encoder.values[i - 1];
    rates.push_back((turned - two_pi * std::round((turned - planned * time) / two_pi)) / time);
  }
  return rates;
}

double median_of(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  if (values.empty()) return std::nan("");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Samples to leave out at both ends.
struct Uneven {
  std::size_t begin = 0, end = 0;
};

Uneven uneven_of(const std::vector<double>& rates) {
  const double rate = median_of(rates);
  std::vector<double> away;
  for (const double one : rates) away.push_back(std::abs(one - rate));
  const double departs = std::max(
      {departs_share * std::abs(rate), departs_sd * sd_of_median_size * median_of(away), departs_at_rest * degree});
  const auto first_even = [&](auto begin, auto end) {
    std::size_t run = 0, at = 0;
    for (auto one = begin; one != end; ++one, ++at) {
      run = *one > departs ? 0 : run + 1;  // a missing reading departs from nothing
      if (run == even_in_succession) return at + 1 - run;
    }
    return at;
  };
  return {first_even(away.begin(), away.end()), first_even(away.rbegin(), away.rend())};
}

/// Cuts the spin to what one encoder shows as even; [s] that are left out at both ends.
void cut_by(const Channel& encoder, double planned, double step, Spin& spin, double& at_begin, double& at_end) {
  const std::size_t first = index_at(encoder, spin.begin),
                    last = std::min(index_at(encoder, spin.end), encoder.values.size());
  if (last < first + fewest_readings) return;
  const Uneven uneven = uneven_of(rates_between(encoder, first, last, planned));
  if (uneven.begin == 0 && uneven.end == 0) return;
  // one more: within it the turning became even
  const double begin = uneven.begin > 0 ? encoder.time(first + uneven.begin + 1) : spin.begin;
  const double end = uneven.end > 0 ? encoder.time(last - 1 - std::min(last - 1, uneven.end + 1)) : spin.end;
  if (!(end - begin > least_remaining * (spin.end - spin.begin) + step)) return;
  at_begin = std::max(at_begin, begin - spin.begin);
  at_end = std::max(at_end, spin.end - end);
  spin.begin = begin;
  spin.end = end;
}

}  // namespace

void cut_to_even_turning(Test& test) {
  double at_begin = 0.0, at_end = 0.0;
  Occurrences cut{0, {}, {}};
  for (auto* spins : {&test.rests, &test.levels})
    for (Spin& spin : *spins) {
      const Channels& channels = test.channels[spin.recording];
      double begin = 0.0, end = 0.0;
      cut_by(*channels.arm, spin.arm_rate, channels.arm_step, spin, begin, end);
      cut_by(*channels.table, spin.table_rate, channels.table_step, spin, begin, end);
      if (begin == 0.0 && end == 0.0) continue;
      if (cut.count++ == 0) cut.first = where_of(spin);
      if (std::max(begin, end) > std::max(at_begin, at_end)) cut.worst = where_of(spin);
      at_begin = std::max(at_begin, begin);
      at_end = std::max(at_end, end);
    }
  if (cut.count > 0)
    test.findings.push_back({Finding::Severity::warning,
                             "levels_cut_to_even_turning",
                             {{"begin", at_begin, "s"}, {"end", at_end, "s"}},
                             "",
                             cut});
}

}  // namespace tumble::dtg_centrifuge
