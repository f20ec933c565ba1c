#include "tumble/methods/fog_thermal_bias/departures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/stability/allan_fit.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::fog_thermal_bias {
namespace {

constexpr double greatest_condition = 1e12;  ///< of the normal equations, beyond which the columns are dependent

constexpr double reversal = 1.0, span = 40.0;                   ///< [K]
constexpr std::array<double, 3> rate_lags{180.0, 900.0, hour};  ///< [s]
constexpr double gradient_lag = 900.0;                          ///< [s]

/// Direction of the last movement by `reversal` or more.
class Direction {
 public:
  double at(double temperature) {
    if (first_) lowest_ = highest_ = temperature;
    first_ = false;
    lowest_ = std::min(lowest_, temperature);
    highest_ = std::max(highest_, temperature);
    if (temperature - lowest_ >= reversal) direction_ = 1.0, highest_ = temperature, lowest_ = temperature - reversal;
    if (highest_ - temperature >= reversal) direction_ = -1.0, lowest_ = temperature, highest_ = temperature + reversal;
    return direction_;
  }

 private:
  bool first_ = true;
  double lowest_ = 0.0, highest_ = 0.0, direction_ = 0.0;
};

const char* name_of(Departure departure) {
  return departure == Departure::hysteresis ? "rising against falling temperature" : "lag of heat";
}

std::vector<std::size_t> positions_in(const std::vector<std::size_t>& factorised,
                                      const std::vector<std::size_t>& columns) {
  std::vector<std::size_t> positions;
  for (const auto column : columns)
    positions.push_back(static_cast<std::size_t>(std::ranges::find(factorised, column) - factorised.begin()));
  return positions;
}

std::vector<std::size_t> joined(std::vector<std::size_t> a, const std::vector<std::size_t>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Rows of the chosen columns of the fitted runs, every run less its mean.
Matrix centred_rows(const std::vector<RunData>& runs, const std::vector<std::size_t>& columns) {
  std::size_t rows = 0;
  const auto measured = [](const RunData& run, std::size_t k) { return !run.held_out && run.share[k] > 0.0; };
  for (const auto& run : runs)
    for (std::size_t k = 0; k < run.time.size(); ++k) rows += measured(run, k) ? 1 : 0;
  Matrix out(rows, columns.size());
  std::size_t first = 0;
  for (const auto& run : runs) {
    std::size_t row = first;
    for (std::size_t k = 0; k < run.time.size(); ++k) {
      if (!measured(run, k)) continue;
      for (std::size_t c = 0; c < columns.size(); ++c) out(row, c) = run.regressors(k, columns[c]);
      ++row;
    }
    for (std::size_t c = 0; c < columns.size(); ++c) {
      double mean = 0.0;
      for (std::size_t k = first; k < row; ++k) mean += out(k, c) / static_cast<double>(row - first);
      for (std::size_t k = first; k < row; ++k) out(k, c) -= mean;
    }
    first = row;
  }
  return out;
}

double mean_square(std::span<const double> values) {
  return values.empty() ? 0.0 : dot(values, values) / static_cast<double>(values.size());
}

/// Mean over the rows of x' C x.
double mean_variance(const Matrix& rows, const Matrix& covariance) {
  double sum = 0.0;
  const Matrix squares = gram(rows);
  for (std::size_t i = 0; i < squares.rows; ++i)
    for (std::size_t j = 0; j < squares.columns; ++j) sum += squares(i, j) * covariance(i, j);
  return rows.rows > 0 ? sum / static_cast<double>(rows.rows) : 0.0;
}

}  // namespace

const std::vector<Departure>& departure_columns() {
  using enum Departure;
  static const std::vector<Departure> columns{hysteresis, hysteresis, lag, lag, lag, lag};
  return columns;
}

Matrix departures_of(const RunData& run, double interval) {
  Matrix out(run.time.size(), departure_columns().size());
  Direction direction;
  std::array<double, rate_lags.size()> rates{};
  double gradient = 0.0, towards = 0.0;
  bool begun = false;
  for (std::size_t k = 0; k < run.time.size(); ++k) {
    if (run.share[k] > 0.0) {
      const Felt& felt = run.felt[k];
      if (!begun) gradient = felt.temperature_gradient;
      begun = true;
      towards = direction.at(felt.temperature);
      for (std::size_t l = 0; l < rates.size(); ++l)
        rates[l] += (1.0 - std::exp(-interval / rate_lags[l])) * (felt.temperature_rate - rates[l]);
      gradient += (1.0 - std::exp(-interval / gradient_lag)) * (felt.temperature_gradient - gradient);
      out(k, 0) = towards;
      out(k, 1) = towards * (felt.temperature - felt.start_temperature) / span;
      for (std::size_t l = 0; l < rates.size(); ++l) out(k, 2 + l) = rates[l];
      out(k, 2 + rates.size()) = gradient;
    }
  }
  return out;
}

std::vector<std::size_t> determined_departures(const std::vector<RunData>& runs, const std::vector<std::size_t>& model,
                                               std::size_t first) {
  constexpr double new_share = 0.05;        // of a column's rms that the model does not explain
  constexpr double averages_a_column = 10;  // and more, for the noise to be known
  std::vector<std::size_t> departures;
  for (std::size_t d = 0; d < departure_columns().size(); ++d) departures.push_back(first + d);
  const Matrix rows = centred_rows(runs, joined(model, departures));
  if (static_cast<double>(rows.rows) < averages_a_column * static_cast<double>(rows.columns)) return {};
  const Matrix unit = scaled_columns(rows, inverses(column_norms(rows), 1e-300));
  const Matrix r = upper_of(householder_qr(unit));
  std::vector<std::size_t> out;
  for (std::size_t d = 0; d < departures.size(); ++d)
    if (std::abs(r(model.size() + d, model.size() + d)) > new_share) out.push_back(departures[d]);
  return out;
}

Misfit misfit_of(const Factors& factors, const std::vector<std::size_t>& factorised, const std::vector<RunData>& runs,
                 const std::vector<std::size_t>& columns, const std::vector<double>& parameters,
                 const std::vector<std::size_t>& departures, std::size_t first) {
  Misfit out;
  if (departures.empty()) return out;
  const auto every = joined(columns, departures);
  const LinearFit plain = joint(factors, positions_in(factorised, columns), {}),
                  full = joint(factors, positions_in(factorised, every), {});
  if (!full.unobservable.empty() || !(full.degrees_of_freedom > 0.0)) return out;
  const double scale = full.chi_square / full.degrees_of_freedom;
  std::vector<double> change = full.parameters;
  for (std::size_t c = 0; c < columns.size(); ++c) change[c] -= parameters[c];
  const Matrix rows = centred_rows(runs, every);
  // What the columns of one kind add to the model by themselves: beside the others they would share it.
  const auto alone = [&](Departure departure) {
    std::vector<std::size_t> with = columns;
    for (const auto column : departures)
      if (departure_columns()[column - first] == departure) with.push_back(column);
    std::vector<double> added = joint(factors, positions_in(factorised, with), {}).parameters;
    for (std::size_t c = 0; c < columns.size(); ++c) added[c] -= plain.parameters[c];
    return std::sqrt(mean_square(centred_rows(runs, with) * added));
  };
  for (const Departure departure : {Departure::hysteresis, Departure::lag}) {
    std::vector<std::size_t> others = columns;
    for (const auto column : departures)
      if (departure_columns()[column - first] != departure) others.push_back(column);
    const double count = static_cast<double>(every.size() - others.size());
    if (count == 0.0) continue;
    const LinearFit without = joint(factors, positions_in(factorised, others), {});
    const double ratio = (without.chi_square - full.chi_square) / scale / count;
    out.parts.push_back({departure, alone(departure), chi_square_tail(ratio, count)});
  }
  const double by_noise = mean_variance(rows, (1.0 / full.inflation) * full.covariance) -
                          mean_variance(centred_rows(runs, columns), (1.0 / plain.inflation) * plain.covariance);
  out.sd = std::sqrt(std::max(0.0, mean_square(rows * change) - scale * std::max(0.0, by_noise)));
  return out;
}

namespace {

/// x_k - x_0 of the averages of a run with data.
Matrix rows_since_start(const RunData& run, const std::vector<std::size_t>& columns) {
  std::vector<std::size_t> measured;
  for (std::size_t k = 0; k < run.time.size(); ++k)
    if (run.share[k] > 0.0) measured.push_back(k);
  Matrix rows(measured.size(), columns.size());
  for (std::size_t k = 0; k < measured.size(); ++k)
    for (std::size_t c = 0; c < columns.size(); ++c)
      rows(k, c) = run.regressors(measured[k], columns[c]) - run.regressors(measured.front(), columns[c]);
  return rows;
}

/// Difference between the fit of all columns to all runs and that of the chosen ones to some.
struct Change {
  std::vector<double> value;
  Matrix covariance;  ///< of it, by noise of unit variance
  Matrix of_chosen;   ///< covariance of the chosen ones, likewise
  bool determined = true;
};

struct Normal {
  Matrix matrix;
  std::vector<double> right;
};

/// Normal equations of all runs, in columns of unit length.
class AllRuns {
 public:
  /// Given: places of the chosen ones among the columns at `positions`.
  AllRuns(const Factors& factors, const std::vector<std::size_t>& positions, const std::vector<std::size_t>& chosen)
      : which_(positions.size(), chosen.size()) {
    const std::size_t n = positions.size();
    for (std::size_t c = 0; c < chosen.size(); ++c) which_(chosen[c], c) = 1.0;
    all_ = {Matrix(n, n), std::vector<double>(n, 0.0)};
    for (const Matrix& triangle : factors.triangles) {
      const Matrix block = chosen_columns(triangle, positions);
      own_.push_back({gram(block), transposed_product(block, column(triangle, triangle.columns - 1))});
      all_.matrix += own_.back().matrix;
    }
    for (std::size_t c = 0; c < n; ++c) unit_.push_back(1.0 / std::sqrt(std::max(all_.matrix(c, c), 1e-300)));
    all_.matrix = in_unit_columns(scaled_rows(unit_, all_.matrix));
    for (Normal& own : own_) {
      own = {in_unit_columns(scaled_rows(unit_, own.matrix)), scaled(unit_, own.right)};
      for (std::size_t c = 0; c < n; ++c) all_.right[c] += own.right[c];
    }
    covariance_ = inverse_symmetric(all_.matrix);
    full_ = covariance_ * all_.right;
  }

  Matrix in_unit_columns(const Matrix& rows) const { return scaled_columns(rows, unit_); }
  const Normal& whole() const { return all_; }
  Normal without(std::size_t run) const {
    return {all_.matrix - own_[run].matrix, difference(all_.right, own_[run].right)};
  }
  Change change(const Normal& some) const {
    const Matrix information = sandwich(transposed(which_), some.matrix);
    const Matrix placed = sandwich(which_, inverse_symmetric(information));
    const Matrix common = covariance_ * some.matrix * placed;
    return {difference(full_, placed * some.right), covariance_ + placed - common - transposed(common), placed,
            condition(information) < greatest_condition};
  }

 private:
  Matrix which_, covariance_;
  std::vector<double> unit_, full_;
  Normal all_;
  std::vector<Normal> own_;
};

}  // namespace

double predicted_misfit(const Factors& factors, const std::vector<std::size_t>& factorised,
                        const std::vector<RunData>& runs, const std::vector<std::size_t>& columns,
                        const std::vector<std::size_t>& chosen, const std::vector<std::size_t>& departures) {
  constexpr double little = 4.0;  // times the variance of the fit of all runs, from which others say little
  const auto every = joined(columns, departures);
  const auto positions = positions_in(factorised, every);
  const LinearFit full = joint(factors, positions, {});
  if (departures.empty() || !full.unobservable.empty() || !(full.degrees_of_freedom > 0.0)) return 0.0;
  const double scale = full.chi_square / full.degrees_of_freedom;
  const AllRuns all(factors, positions, positions_in(every, chosen));
  double squares = 0.0, count = 0.0;
  std::size_t fitted = 0;
  for (const auto& run : runs) {
    if (run.held_out) continue;
    const Matrix rows = all.in_unit_columns(rows_since_start(run, every));
    const Change inside = all.change(all.whole()), outside = all.change(all.without(fitted++));
    const double known = mean_variance(rows, inside.of_chosen), by_others = mean_variance(rows, outside.of_chosen);
    const Change& change = outside.determined && by_others < little * known ? outside : inside;
    squares += dot(rows * change.value, rows * change.value) -
               scale * mean_variance(rows, change.covariance) * static_cast<double>(rows.rows);
    count += static_cast<double>(rows.rows);
  }
  return count > 0.0 ? std::sqrt(std::max(0.0, squares / count)) : 0.0;
}

Table misfit_table(const Misfit& misfit) {
  struct Row {
    std::string departure;
    double sd, p_value;
  };
  std::vector<Row> rows;
  for (const auto& part : misfit.parts) rows.push_back({name_of(part.departure), part.sd, part.p_value});
  rows.push_back({"all", misfit.sd, std::nan("")});
  rows.push_back({"all, since the start of a run that the others predict", misfit.predicted, std::nan("")});
  return tabulate("misfit", "drift that the model does not follow, as columns beside it show: rms over the averages",
                  rows, {{"departure", &Row::departure}, {"sd", "deg/h", &Row::sd}, {"p-value", &Row::p_value}});
}

}  // namespace tumble::fog_thermal_bias
