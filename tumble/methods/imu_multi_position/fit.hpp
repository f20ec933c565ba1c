#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tumble/methods/imu_multi_position/chain.hpp"
#include "tumble/methods/imu_multi_position/moves.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::imu_multi_position {

/// The parameters in order: A (xx, yx, yy, zx, zy, zz), a, then the columns of W, b, the columns of G; after those come
/// three for the rotation of the Earth, in the axes of the first rest.
inline constexpr std::size_t with_gyros = 21, with_sensitivity = 30;
/// Column 3: b; 4 to 6: G.
constexpr std::size_t gyro_index(std::size_t row, std::size_t column) { return of_accelerometers + 3 * column + row; }

/// A mean of the accelerometers or of the gyros, the turn of a move, the prior knowledge of the Earth's rotation.
enum class Part { force, rate, turn, earth };
inline constexpr std::array<Part, 3> parts{Part::force, Part::rate, Part::turn};

/// Variance of each part in addition to noise [(m/s^2)^2, (rad/s)^2, 1, -].
using Scatter = std::array<double, 4>;

/// One observation, linearised.
struct Row {
  double residual = 0.0;
  std::array<double, 24> common{};              ///< derivative by the parameters from Group::first on
  std::array<double, Chain::width> chain{};     ///< derivative by the directions of a rest and of the next one
  double white = 0.0, earth = 0.0, unit = 0.0;  ///< variances; unit: of scatter
};

/// Observations that belong together: up to three rows, of one rest or one move.
struct Group {
  Part part = Part::force;
  std::size_t index = 0;  ///< of the rest in Rests::all, or of the move
  std::size_t pair = 0;   ///< rest of the chain, with two unknowns; a move ties it to the next
  std::size_t first = 0;  ///< parameter of the first column
  std::size_t columns = 0;
  std::vector<Row> rows;
  /// How many numbers of directions its rows depend on.
  std::size_t unknowns() const { return part == Part::turn ? 4 : 2; }
  double distance = 0.0;  ///< of the residual from 0, in standard deviations
  bool used = true;
};

struct FitOptions {
  double gravity = standard_gravity;  ///< [m/s^2]
  std::optional<double> latitude;     ///< [rad] for the rotation of the Earth about the vertical
  double latitude_sd = 0.0;           ///< [rad]
  bool sensitivity = true;            ///< G is sought
};

/// The sources of a covariance, as budgets list them.
inline constexpr std::array<const char*, 7> sources{"noise of the accelerometers at rest",
                                                    "scatter of the accelerometers from rest to rest",
                                                    "noise of the gyros at rest",
                                                    "scatter of the gyros from rest to rest",
                                                    "noise of the gyros in the moves",
                                                    "scatter of the moves, in proportion to the turn",
                                                    "rotation of the Earth"};

struct Fit {
  Calibration calibration;
  std::size_t parameters = of_accelerometers;  ///< without those of the Earth
  std::size_t unknowns() const { return parameters + (parameters > of_accelerometers ? 3 : 0); }
  std::vector<std::size_t> chain;                  ///< the rests in use
  std::vector<Vector3> direction;                  ///< of gravity (up), of each of them
  Vector3 earth;                                   ///< [rad/s] its rotation in the axes of the first rest
  std::vector<std::optional<Matrix3>> from_first;  ///< axes of each rest from those of the first, where moves show it
  std::vector<Move> moves;
  std::vector<Turn> turns;  ///< one a move; empty where it is not used
  std::vector<Group> groups;
  Scatter scatter{};
  std::array<bool, 3> scatter_significant{};  ///< false: noise alone
  Matrix covariance;                          ///< of the parameters
  std::array<Matrix, sources.size()> shares;  ///< sum to it
  std::vector<double> degrees_of_freedom;
  double chi_square = 0.0;
  std::size_t observations = 0;
  double condition = 0.0;
  bool gyros_without_turns = false;  ///< the moves do not show the gyros, which are not in it
};

/// All rests and moves together: generalised least squares with the direction of gravity at each rest as two unknowns
/// in addition to the parameters; the scatter of each part beyond its noise by restricted maximum likelihood; outliers
/// among rests and moves are rejected.
///
///   y_a = A g n_k + a,   y_g = W C_k w_ie + b + G g n_k,   n_(k+1) = R_k' n_k
Fit fit_all(const std::vector<Session>& sessions, Rests& rests, const FitOptions& options);

// How far the observations scatter, and the uncertainty that follows: variance.cpp.

/// Normal equations of the groups in use, with their present variances.
Chain normal_equations(const Fit& fit);

/// The residual of a group in standard deviations [1].
double distance_of(const Group& group, const Fit& fit);

/// Fit::scatter by restricted maximum likelihood at the present linearisation, one part after the other, `rounds`
/// times.
void find_scatter(int rounds, Fit& fit);

/// Covariance with its shares and degrees of freedom (Satterthwaite). `noise_degrees` [1]: of the noise at rest.
void add_uncertainty(double noise_degrees, Fit& fit);

/// Error::bad_data: the rests do not show all parameters.
[[noreturn]] void throw_singular();

}  // namespace tumble::imu_multi_position
