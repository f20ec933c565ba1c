#include "tumble/methods/fog_thermal_bias/beside_model.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/whitening.hpp"
#include "tumble/math/stability/allan_fit.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::fog_thermal_bias {
namespace {

constexpr double rare_beside = 1e-4;  ///< probability in a sound test, of all that is tried together
/// Likewise of a cycle, which slow noise resembles: how much of that there is, a test shows to a factor only. With 1e-4 four
/// of 100 sound tests were accused.
constexpr double rare_cycle = 1e-12;
constexpr double same_as_others =
    1e-9;                        ///< [1] of the square of a column that the others do not explain: it is rounding
constexpr int half_cycles = 40;  ///< of the record: to and fro in a half to twenty cycles
constexpr double settling_parts[] = {20.0, 10.0, 5.0, 2.5};  ///< length of the record over the time constants tried

/// Fills the columns from the one given on with what is tried, for the averages of one run.
using Fill = std::function<void(const RunData& run, std::size_t first, Matrix& block)>;

/// One or two columns beside the model.
struct Beside {
  double chance = 1.0;  ///< of so much by noise
  double first = 0.0, second = 0.0;
};

/// Takes a column and its row out of a matrix of products; without effect where the others hold it already.
void eliminate(std::size_t pivot, double whole, Matrix& products) {
  const double own = products(pivot, pivot);
  if (!(own > same_as_others * whole)) return;
  const Matrix before = products;
  for (std::size_t i = 0; i < products.rows; ++i)
    for (std::size_t j = 0; j < products.columns; ++j) products(i, j) -= before(i, pivot) * before(pivot, j) / own;
}

/// Products of the whitened columns of a run, its level taken out: model, tried, output.
Matrix products_of(const RunData& run, const Answer& answer, double interval, std::size_t tried, const Fill& fill) {
  const std::size_t model = answer.columns.size(), last = model + tried + 1;
  Matrix block(run.time.size(), last + 1);
  fill(run, model + 1, block);
  for (std::size_t k = 0; k < run.time.size(); ++k) {
    const double measured = run.share[k] > 0.0 ? 1.0 : 0.0;
    block(k, 0) = measured;
    for (std::size_t c = 0; c < model; ++c) block(k, c + 1) = measured * run.regressors(k, answer.columns[c]);
    for (std::size_t c = model + 1; c < last; ++c) block(k, c) *= measured;
    block(k, last) = measured * (run.output[k] - run.start_output);
  }
  Whitening(answer.noise, interval, run.time.back() + 0.5 * interval)(block, run.share);
  Matrix products = gram(block);
  eliminate(0, products(0, 0), products);
  return products;
}

Beside tested(const Answer& answer, double interval, std::size_t tried, const Fill& fill) {
  const std::size_t model = answer.columns.size(), y = model + tried + 1;
  Matrix all(y + 1, y + 1);
  for (const RunData& run : answer.runs)
    if (!run.held_out && !run.time.empty()) all += products_of(run, answer, interval, tried, fill);
  const std::vector<double> whole = diagonal_of(all);
  for (std::size_t c = 1; c <= model; ++c) eliminate(c, whole[c], all);
  const std::size_t a = model + 1, b = a + tried - 1;
  const double aa = all(a, a), bb = all(b, b), ab = all(a, b), ay = all(a, y), by = all(b, y);
  const double determinant = tried == 1 ? aa : aa * bb - ab * ab;
  if (!(aa > same_as_others * whole[a]) || !(determinant > same_as_others * (tried == 1 ? whole[a] : aa * bb)))
    return {};
  Beside out;
  out.first = tried == 1 ? ay / aa : (bb * ay - ab * by) / determinant;
  out.second = tried == 1 ? 0.0 : (aa * by - ab * ay) / determinant;
  const double square = (out.first * ay + out.second * by) / answer.fit.inflation;
  out.chance = chi_square_tail(square, static_cast<double>(tried));
  return out;
}

/// The rate at which the drift of the model changes [rad/s^2].
void fill_change(const Answer& answer, double interval, const RunData& run, std::size_t column, Matrix& block) {
  const auto drift = [&](std::size_t k) {
    double sum = 0.0;
    for (std::size_t c = 0; c < answer.columns.size(); ++c)
      sum += answer.fit.parameters[c] * run.regressors(k, answer.columns[c]);
    return sum;
  };
  const std::size_t n = run.time.size();
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t before = k > 0 && run.share[k - 1] > 0.0 ? k - 1 : k;
    const std::size_t after = k + 1 < n && run.share[k + 1] > 0.0 ? k + 1 : k;
    if (after > before)
      block(k, column) = (drift(after) - drift(before)) / (interval * static_cast<double>(after - before));
  }
}

/// Length [s] of the record that holds all power-ups; 0 where they are in several.
double length_of(const Answer& answer) {
  double begin = INFINITY, end = -INFINITY;
  for (const RunData& run : answer.runs) {
    if (run.recording != answer.runs.front().recording || !std::isfinite(run.begin)) return 0.0;
    begin = std::min(begin, run.begin);
    if (!run.time.empty()) end = std::max(end, run.begin + run.time.back());
  }
  return std::max(0.0, end - begin);
}

/// A finding and the probability of so much by noise, of all that was tried for it.
struct Said {
  double chance = 1.0;
  Finding finding{Finding::Severity::warning, "", {}};
};

Said lateness(const Answer& answer, double interval) {
  const Beside late = tested(answer, interval, 1, [&](const RunData& run, std::size_t column, Matrix& block) {
    fill_change(answer, interval, run, column, block);
  });
  return {late.chance,
          {Finding::Severity::warning,
           "output_late_on_temperature",
           {{"delay", -late.first, "s"}, {"p", std::max(1e-6, late.chance)}}}};
}

Said cycles(const Answer& answer, double interval, double length) {
  Beside rarest;
  double period = 0.0;
  for (int half = 1; half <= half_cycles; ++half) {
    const double rate = pi * half / length;
    const Beside cycle = tested(answer, interval, 2, [&](const RunData& run, std::size_t column, Matrix& block) {
      for (std::size_t k = 0; k < run.time.size(); ++k) {
        const double angle = rate * (run.begin - answer.runs.front().begin + run.time[k]);
        block(k, column) = std::cos(angle), block(k, column + 1) = std::sin(angle);
      }
    });
    if (cycle.chance < rarest.chance) rarest = cycle, period = two_pi / rate;
  }
  const double chance = half_cycles * rarest.chance * (rare_beside / rare_cycle);
  return {chance,
          {Finding::Severity::warning,
           "output_goes_up_and_down",
           {{"amplitude", std::hypot(rarest.first, rarest.second), "deg/h"},
            {"period", period, "s"},
            {"p", std::max(1e-6, std::min(chance, 1.0))}}}};
}

Said settling(const Answer& answer, double interval, double length) {
  Beside rarest;
  double constant = 0.0;
  for (const double part : settling_parts) {
    const double time = length / part;
    const Beside one = tested(answer, interval, 1, [&](const RunData& run, std::size_t column, Matrix& block) {
      for (std::size_t k = 0; k < run.time.size(); ++k)
        block(k, column) = std::exp(-(run.begin - answer.runs.front().begin + run.time[k]) / time);
    });
    if (one.chance < rarest.chance) rarest = one, constant = time;
  }
  const double chance = static_cast<double>(std::size(settling_parts)) * rarest.chance;
  return {chance,
          {Finding::Severity::warning,
           "output_settles_along_record",
           {{"size", rarest.first, "deg/h"}, {"time", constant, "s"}, {"p", std::max(1e-6, chance)}}}};
}

}  // namespace

Findings beside_model(const Answer& answer, double interval) {
  if (!(answer.noise.angle_random_walk > 0.0) || !std::isfinite(answer.noise.angle_random_walk)) return {};
  std::vector<Said> all{lateness(answer, interval)};
  if (const double length = length_of(answer); length > 0.0 && answer.runs.size() > 1) {
    all.push_back(cycles(answer, interval, length));
    all.push_back(settling(answer, interval, length));
  }
  const Said& rarest = *std::ranges::min_element(all, {}, &Said::chance);
  if (rarest.chance >= rare_beside) return {};
  return {rarest.finding};
}

}  // namespace tumble::fog_thermal_bias
