#include "tumble/tasks/validation/shifts.hpp"

#include <algorithm>
#include <cmath>

namespace tumble::validation {
namespace {

/// Pairs that agree to this part [1] show one shift without noise.
constexpr double alike = 0.25;
/// Shifts below this [sd] do no harm, whatever further pairs show.
constexpr double negligible = 0.3;
/// So many pairs are enough where they scatter [1].
constexpr std::size_t most_pairs = 6;
/// A mean counts beyond this [sd of the mean]: p = 0.016 of five degrees of freedom and 0.003 of nine, and it is one sd of the
/// parameter at least when it matters.
constexpr double beyond_scatter = 3.5;
/// The mean excess of squared deviations counts beyond this [1] times its sd between sound tests, which is 2/sqrt(pairs).
constexpr double beyond_sound = 3.2;

struct Moments {
  double mean = 0.0, sd = 0.0;
};

Moments moments_of(const std::vector<double>& values) {
  Moments moments;
  const auto n = static_cast<double>(values.size());
  for (const double value : values) moments.mean += value / n;
  for (const double value : values) moments.sd += (value - moments.mean) * (value - moments.mean);
  moments.sd = values.size() > 1 ? std::sqrt(moments.sd / (n - 1.0)) : 0.0;
  return moments;
}

}  // namespace

double Shifts::centre(std::size_t j) const {
  for (const auto& [name, value] : bench_.truth)
    if (name == bench_.parameters[j].name) return value;
  return bench_.parameters[j].value;
}

void Shifts::add(const Outcome& departed, const Outcome& sound) {
  ++tests_;
  for (std::size_t j = 0; j < pairs_.size(); ++j) {
    const double shift = (departed.values[j] - sound.values[j]) / departed.sds[j];
    if (std::isnan(shift)) continue;
    const double with = (departed.values[j] - centre(j)) / departed.sds[j];
    const double without = (sound.values[j] - centre(j)) / sound.sds[j];
    pairs_[j].shifts.push_back(shift);
    pairs_[j].squares += with * with - without * without;
  }
}

bool Shifts::settled() const {
  if (tests_ < 2) return false;
  if (tests_ >= most_pairs) return true;
  return std::ranges::all_of(pairs_, [](const Pairs& pairs) {
    const auto [mean, sd] = moments_of(pairs.shifts);
    return sd <= alike * std::abs(mean) || std::abs(mean) + sd < negligible;
  });
}

double Shifts::shift_of(const Pairs& pairs) {
  if (pairs.shifts.empty()) return 0.0;
  const auto n = static_cast<double>(pairs.shifts.size());
  const auto [mean, sd] = moments_of(pairs.shifts);
  if (std::abs(mean) > beyond_scatter * sd / std::sqrt(n)) return std::abs(mean);
  const double excess = pairs.squares / n;
  return excess > beyond_sound * 2.0 / std::sqrt(n) ? std::sqrt(excess) : 0.0;
}

Shift Shifts::worst() const {
  Shift worst;
  for (std::size_t j = 0; j < pairs_.size(); ++j)
    if (const double size = shift_of(pairs_[j]); size > worst.size) worst = {size, j};
  return worst;
}

}  // namespace tumble::validation
