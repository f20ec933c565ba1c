#include "tumble/math/population/gauge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "tumble/math/random.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Sqrt(2) as rounded by AIAG, Measurement Systems Analysis: number of distinct categories.
constexpr double of_categories = 1.41;

void require_complete(const GaugeStudy& study) {
  Problems problems;
  for (const auto& [what, count] : {std::pair{"units", study.units}, {"rigs", study.rigs}, {"repeats", study.repeats}})
    if (count < 2) problems.push_back(say("a gauge study needs at least two {}; here {} given", what, count));
  if (study.values.size() != study.units * study.rigs * study.repeats)
    problems.push_back(say("{} units on {} rigs with {} repeats are {} results; here {} given", study.units, study.rigs,
                           study.repeats, study.units * study.rigs * study.repeats, study.values.size()));
  if (!std::ranges::all_of(study.values, [](double value) { return std::isfinite(value); }))
    problems.push_back("a result of the gauge study is missing");
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

/// Mean squares of units, rigs, units on rigs, and repeats, with their degrees of freedom.
struct MeanSquares {
  std::array<double, 4> value{}, freedom{};
};

MeanSquares mean_squares(const GaugeStudy& study) {
  const auto P = study.units, O = study.rigs, R = study.repeats;
  const auto p = static_cast<double>(P), o = static_cast<double>(O), r = static_cast<double>(R);
  std::vector<double> unit(P), rig(O), cell(P * O);
  double all = 0.0;
  for (std::size_t i = 0; i < P; ++i)
    for (std::size_t j = 0; j < O; ++j)
      for (std::size_t k = 0; k < R; ++k) {
        const double value = study.values[(i * O + j) * R + k];
        unit[i] += value / (o * r), rig[j] += value / (p * r), cell[i * O + j] += value / r, all += value / (p * o * r);
      }
  std::array<double, 4> squares{};
  for (const double mean : unit) squares[0] += o * r * square(mean - all);
  for (const double mean : rig) squares[1] += p * r * square(mean - all);
  for (std::size_t i = 0; i < P; ++i)
    for (std::size_t j = 0; j < O; ++j) {
      squares[2] += r * square(cell[i * O + j] - unit[i] - rig[j] + all);
      for (std::size_t k = 0; k < R; ++k) squares[3] += square(study.values[(i * O + j) * R + k] - cell[i * O + j]);
    }
  MeanSquares out;
  out.freedom = {p - 1.0, o - 1.0, (p - 1.0) * (o - 1.0), p * o * (r - 1.0)};
  for (std::size_t s = 0; s < 4; ++s) out.value[s] = squares[s] / out.freedom[s];
  return out;
}

/// Repeatability, reproducibility, gauge, units [u] and gauge/total [1] from mean squares.
std::array<double, 5> parts_of(const std::array<double, 4>& ms, const GaugeStudy& study) {
  const auto p = static_cast<double>(study.units), o = static_cast<double>(study.rigs),
             r = static_cast<double>(study.repeats);
  const double repeat = ms[3];
  const double gauge = (ms[1] + (p - 1.0) * ms[2] + p * (r - 1.0) * ms[3]) / (p * r);
  const double units = std::max(0.0, (ms[0] - ms[2]) / (o * r));
  const double total = gauge + units;
  return {std::sqrt(repeat), std::sqrt(std::max(0.0, gauge - repeat)), std::sqrt(gauge), std::sqrt(units),
          total > 0.0 ? std::sqrt(gauge / total) : 0.0};
}

}  // namespace

Gauge gauge_of(const GaugeStudy& study, std::uint64_t seed) {
  require_complete(study);
  constexpr std::size_t draws = 1000;
  const auto found = mean_squares(study);
  const auto best = parts_of(found.value, study);
  std::array<std::vector<double>, 5> drawn;
  for (std::size_t n = 0; n < draws; ++n) {
    auto ms = found.value;
    for (std::size_t s = 0; s < 4; ++s)
      ms[s] *= found.freedom[s] /
               quantile(boost::math::chi_squared(found.freedom[s]), RandomStream(seed).split(s).uniform(n));
    const auto parts = parts_of(ms, study);
    for (std::size_t k = 0; k < parts.size(); ++k) drawn[k].push_back(parts[k]);
  }
  const auto value = [&](std::size_t k) {
    std::ranges::sort(drawn[k]);
    return GaugeValue{best[k], drawn[k][draws / 40], drawn[k][draws - 1 - draws / 40]};
  };
  Gauge out{value(0), value(1), value(2), value(3), value(4)};
  out.categories = out.gauge.value > 0.0 ? std::floor(of_categories * out.units.value / out.gauge.value)
                                         : std::numeric_limits<double>::infinity();
  return out;
}

}  // namespace tumble
