#include "tumble/methods/fog_thermal_bias/surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/core/columns.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/fog_thermal_bias/range.hpp"

namespace tumble::fog_thermal_bias {
namespace {

constexpr std::size_t columns_of_map = 24, rows_of_map = 16;

/// Cells of one width from the smallest to the largest value.
struct Cuts {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  std::size_t count;

  void add(double value) { low = std::min(low, value), high = std::max(high, value); }
  double width() const { return (high - low) / static_cast<double>(count); }
  double middle(std::size_t i) const { return low + width() * (static_cast<double>(i) + 0.5); }
  std::size_t place(double value) const {
    return std::min(count - 1, static_cast<std::size_t>(std::max(0.0, (value - low) / width())));
  }
};

/// The gradient that goes with a rate: a straight line through the averages.
struct GradientOfRate {
  double level = 0.0, slope = 0.0;  ///< [K], [s]
  explicit GradientOfRate(const std::vector<RunData>& runs) {
    double count = 0.0, r = 0.0, g = 0.0, rr = 0.0, rg = 0.0;
    each_average(runs, [&](const RunData& run, std::size_t k) {
      const Felt& felt = run.felt[k];
      count += 1.0, r += felt.temperature_rate, g += felt.temperature_gradient;
      rr += felt.temperature_rate * felt.temperature_rate, rg += felt.temperature_rate * felt.temperature_gradient;
    });
    const double spread = rr - r * r / count;
    slope = spread > 0.0 ? (rg - r * g / count) / spread : 0.0;
    level = (g - slope * r) / count;
  }
};

class Surface {
 public:
  Surface(const std::vector<Term>& terms, const Answer& answer, double start)
      : terms_(terms),
        answer_(answer),
        gradient_(answer.runs),
        start_(start),
        at_start_(raw(felt_at(start, 0.0, 0.0))) {}

  Felt felt(double temperature, double rate) const {
    return felt_at(temperature, gradient_.level + gradient_.slope * rate, rate);
  }
  /// What multiplies the coefficients.
  std::vector<double> regressors(double temperature, double rate) const {
    auto phi = raw(felt(temperature, rate));
    for (std::size_t c = 0; c < phi.size(); ++c) phi[c] -= at_start_[c];
    return phi;
  }
  double drift(const std::vector<double>& phi) const { return dot(phi, answer_.fit.parameters); }

 private:
  Felt felt_at(double temperature, double gradient, double rate) const {
    constexpr double long_after = 1e9;  // [s] no start-up transient any more
    return {{}, {}, {}, temperature, gradient, rate, start_, long_after};
  }
  std::vector<double> raw(const Felt& felt) const {
    std::vector<double> phi;
    for (const auto column : answer_.columns) phi.push_back(terms_[column].regressor(felt));
    return phi;
  }

  const std::vector<Term>& terms_;
  const Answer& answer_;
  GradientOfRate gradient_;
  double start_;
  std::vector<double> at_start_;
};

Table map_table(const Surface& surface, const Answer& answer, const Matrix& covariance, const Cuts& temperature,
                const Cuts& rate, double start) {
  struct Cell {
    double temperature, rate;
    std::vector<double> phi;
  };
  std::vector<Cell> cells;
  const InRange in_range(covered(answer.runs));
  for (std::size_t row = 0; row < rate.count; ++row)
    for (std::size_t column = 0; column < temperature.count; ++column) {
      const double t = temperature.middle(column), r = rate.middle(row);
      if (in_range(surface.felt(t, r))) cells.push_back({t, r, surface.regressors(t, r)});
    }
  const auto sd = [&](const Cell& c) { return std::sqrt(std::max(0.0, quadratic_form(c.phi, covariance))); };
  return for_programs(
      tabulate("thermal_map",
               fmt::format("drift since power-on by the coefficients, for a start at {:.3g} degC and the "
                           "gradient that went with the rate",
                           Unit::parse("degC").from_si(start)),
               cells,
               {{"temperature", "degC", &Cell::temperature},
                {"temperature_rate", "K/min", &Cell::rate},
                {"drift", "deg/h", [&](const Cell& c) { return surface.drift(c.phi); }},
                {"drift_sd", "deg/h", sd}}));
}

/// Sums over the averages of a cell.
struct SumsOfCell {
  double count = 0.0, temperature = 0.0, rate = 0.0, drift = 0.0, residual = 0.0;
};

/// What the coefficients leave of each average of a run, less its mean over the run.
std::vector<double> residuals_of(const RunData& run, const Answer& answer) {
  std::vector<double> residuals;
  double sum = 0.0, count = 0.0;
  for (std::size_t k = 0; k < run.time.size(); ++k) {
    double drift = 0.0;
    for (std::size_t c = 0; c < answer.columns.size(); ++c)
      drift += answer.fit.parameters[c] * run.regressors(k, answer.columns[c]);
    residuals.push_back(run.output[k] - drift);
    if (run.share[k] > 0.0) sum += residuals.back(), count += 1.0;
  }
  for (double& residual : residuals) residual -= sum / std::max(1.0, count);
  return residuals;
}

Table points_table(const Surface& surface, const Answer& answer, const Cuts& temperature, const Cuts& rate) {
  std::vector<SumsOfCell> cells(temperature.count * rate.count);
  const RunData* of = nullptr;
  std::vector<double> residuals;
  each_average(answer.runs, [&](const RunData& run, std::size_t k) {
    if (of != &run) residuals = residuals_of(run, answer), of = &run;
    const double t = run.felt[k].temperature, r = run.felt[k].temperature_rate;
    SumsOfCell& cell = cells[rate.place(r) * temperature.count + temperature.place(t)];
    cell.count += 1.0, cell.temperature += t, cell.rate += r, cell.residual += residuals[k];
    cell.drift += surface.drift(surface.regressors(t, r)) + residuals[k];
  });
  std::erase_if(cells, [](const SumsOfCell& cell) { return !(cell.count > 0.0); });
  const auto mean = [](double SumsOfCell::*sum) {
    return [sum](const SumsOfCell& cell) { return cell.*sum / cell.count; };
  };
  return for_programs(tabulate("thermal_points",
                               "means of the averages of a cell, each run less its mean; drift: brought to the start "
                               "temperature and gradient of the map",
                               cells,
                               {{"temperature", "degC", mean(&SumsOfCell::temperature)},
                                {"temperature_rate", "K/min", mean(&SumsOfCell::rate)},
                                {"drift", "deg/h", mean(&SumsOfCell::drift)},
                                {"residual", "deg/h", mean(&SumsOfCell::residual)}}));
}

}  // namespace

std::vector<Table> thermal_surface(const std::vector<Term>& terms, const Answer& answer, const Matrix& covariance,
                                   double reference) {
  Cuts temperature{.count = columns_of_map}, rate{.count = rows_of_map}, start{.count = 1};
  each_average(answer.runs, [&](const RunData& run, std::size_t k) {
    temperature.add(run.felt[k].temperature);
    rate.add(run.felt[k].temperature_rate);
    start.add(run.start_temperature);
  });
  if (!(temperature.high > temperature.low && rate.high > rate.low)) return {};
  const double from = std::clamp(reference, start.low, start.high);
  const Surface surface(terms, answer, from);
  return {map_table(surface, answer, covariance, temperature, rate, from),
          points_table(surface, answer, temperature, rate)};
}

}  // namespace tumble::fog_thermal_bias
