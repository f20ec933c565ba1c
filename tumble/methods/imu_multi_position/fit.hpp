#pragma once

#include <Eigen/Core>
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
inline constexpr Eigen::Index of_accelerometers = 9, with_gyros = 21, with_sensitivity = 30;
constexpr Eigen::Index gyro_index(int row, int column) { return 9 + 3 * column + row; }  ///< column 3: b, 4 to 6: G

/// A mean of the accelerometers, of the gyros, the turn of a move; what is known of the Earth beforehand.
enum class Part { force, rate, turn, earth };
inline constexpr std::array<Part, 3> parts{Part::force, Part::rate, Part::turn};

/// Observations that belong together: up to three rows, of one rest or one move.
struct Group {
  Part part = Part::force;
  std::size_t index = 0;   ///< of the rest in Rests::all, or of the move
  std::size_t pair = 0;    ///< of the chain; a move ties it to the next
  Eigen::Index first = 0;  ///< parameter of the first column
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 24> common;
  Eigen::Matrix<double, Eigen::Dynamic, 2, 0, 3, 2> here, next;
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> residual, white, earth, unit;  ///< variances; unit: of scatter
  double distance = 0.0;  ///< of the residual from 0, in standard deviations
  bool used = true;
};

struct FitOptions {
  double gravity = standard_gravity;  ///< [m/s^2]
  std::optional<double> latitude;     ///< [rad] for the rotation of the Earth about the vertical
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
  Eigen::Index parameters = of_accelerometers;  ///< without those of the Earth
  Eigen::Index unknowns() const { return parameters + (parameters > of_accelerometers ? 3 : 0); }
  std::vector<std::size_t> chain;                   ///< rests in the order of the pairs
  std::vector<Vector3d> direction;                  ///< of gravity (up), of each of them
  Vector3d earth = Vector3d::Zero();                ///< [rad/s] its rotation in the axes of the first rest
  std::vector<std::optional<Matrix3d>> from_first;  ///< axes of each rest from those of the first, where moves tell
  std::vector<Move> moves;
  std::vector<Turn> turns;  ///< one a move; empty where it is not used
  std::vector<Group> groups;
  std::array<double, 4> scatter{};                     ///< variance of each part beside noise [(m/s^2)^2, (rad/s)^2, 1]
  std::array<bool, 3> scatter_seen{};                  ///< false: none beside the noise
  Eigen::MatrixXd covariance;                          ///< of the parameters
  std::array<Eigen::MatrixXd, sources.size()> shares;  ///< sum to it
  Eigen::VectorXd degrees_of_freedom;
  double chi_square = 0.0;
  std::size_t observations = 0;
  double condition = 0.0;
  std::string no_gyros;  ///< why they are not in it; empty: they are, or there are none
};

/// All rests and moves together: generalised least squares with the direction of gravity at each rest as two unknowns
/// beside the parameters; the scatter of each part beyond its noise by restricted maximum likelihood; rests and moves
/// far off the rest left out.
///
///   y_a = A g n_k + a,   y_g = W C_k w_ie + b + G g n_k,   n_(k+1) = R_k' n_k
Fit fit_all(const std::vector<Session>& sessions, Rests& rests, const FitOptions& options);

}  // namespace tumble::imu_multi_position
