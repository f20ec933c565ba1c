#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/fog_thermal_bias/fit.hpp"

/// Departures of a real coil from the model: it depends on the direction from which the temperature came, and its
/// inside follows the case with a lag. These columns are fitted beside the model, so that the noise of the averages is
/// that of the instrument, and an error that the model does not follow is shown as such.
namespace tumble::fog_thermal_bias {

/// Columns of departures_of().
enum class Departure { hysteresis, lag };
const std::vector<Departure>& departure_columns();

/// Departures of one run, from its averages: the direction in which the temperature last moved by 1 K or more (-1, 0 at
/// power-on, 1), alone and times (T - T_0)/(40 K); dT/dt behind lags of 3, 15 and 60 min [K/s]; the gradient behind one
/// of 15 min [K].
/// Given: interval between the averages [s]. Returned: intervals x 6.
Matrix departures_of(const RunData& run, double interval);

/// The columns from `first` on that the columns `model` do not explain within the runs, as indices of columns. None
/// where the averages are too few to fit them.
std::vector<std::size_t> determined_departures(const std::vector<RunData>& runs, const std::vector<std::size_t>& model,
                                               std::size_t first);

/// How far the averages depart from the fitted model.
struct Misfit {
  struct Part {
    Departure departure;
    double sd = 0.0;       ///< rms of what this part adds to a fit with everything else [rad/s]
    double p_value = 1.0;  ///< of a chi-square of as much by noise
  };
  std::vector<Part> parts;
  double sd = 0.0;         ///< rms of all beyond what noise explains, of every run about its mean [rad/s]
  double predicted = 0.0;  ///< see predicted_misfit() [rad/s]
};

/// Given     factors     of the columns `factorised`, departures included
///           columns     of the model, with its fitted `parameters` [SI]
///           departures  columns
///           first       column of the first departure
Misfit misfit_of(const Factors& factors, const std::vector<std::size_t>& factorised, const std::vector<RunData>& runs,
                 const std::vector<std::size_t>& columns, const std::vector<double>& parameters,
                 const std::vector<std::size_t>& departures, std::size_t first);

/// Error of a correction of another power-up, beyond the noise of its coefficients: rms over the averages of the
/// departure since the start of each run, with the coefficients that the other runs give.
///
///   mean over k of ((x_k - x_0)' (b - a_r))^2 - (x_k - x_0)' Cov(b - a_r) (x_k - x_0)
///
/// b of all columns and all runs; a_r of the chosen columns without run r, or of all runs where the others say little
/// about it: such a run extends the range, and nothing predicts it.
///
/// Given     as misfit_of(), and `chosen`, the columns with values, among `columns`
/// Returned  [rad/s]
double predicted_misfit(const Factors& factors, const std::vector<std::size_t>& factorised,
                        const std::vector<RunData>& runs, const std::vector<std::size_t>& columns,
                        const std::vector<std::size_t>& chosen, const std::vector<std::size_t>& departures);

/// Table `misfit`: one row a departure, one for all, and last the predicted one.
Table misfit_table(const Misfit& misfit);

}  // namespace tumble::fog_thermal_bias
