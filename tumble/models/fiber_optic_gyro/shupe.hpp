#pragma once

#include <span>
#include <vector>

namespace tumble::fiber_optic_gyro {

enum class Winding { plain, dipole, quadrupole };

/// A coil of optical fibre. Layer 0 is the innermost.
struct Coil {
  double length = 1000.0;     ///< L of the fibre [m]
  double diameter = 0.1;      ///< D, mean [m]
  double index = 1.45;        ///< n of the core
  double index_slope = 1e-5;  ///< dn/dT [1/K]
  double expansion = 5.5e-7;  ///< alpha of the fibre's length [1/K]
  Winding winding = Winding::quadrupole;
  int layers = 32;              ///< even for a dipole, a multiple of 4 for a quadrupole
  double thickness = 0.01;      ///< of all layers [m]
  double diffusivity = 2e-7;    ///< across the layers [m^2/s]
  bool inner_insulated = true;  ///< no heat through the innermost layer; else its face has a temperature of its own
};

/// Apparent rate [rad/s] for sections of the fibre that change their temperature at these rates [K/s], all sections of
/// one length, from where the clockwise wave enters to where it leaves.
///
///   W = n/(L D) (dn/dT + n alpha) INT_0^L Tdot(z) (2 z - L) dz                                             (4.29)
double shupe_rate(const Coil& coil, std::span<const double> temperature_rates);

/// Weights of the layers: INT (2 z - L) dz over the fibre of each layer [m^2].
///
/// plain: the fibre goes from the innermost layer to the outermost. dipole and quadrupole: wound from its middle,
/// layers of the halves A, B in the order A B A B ... and A B B A ..., so that near each other lie parts at the same
/// distance from the middle, with opposite weights.
std::vector<double> layer_weights(const Coil& coil);

/// Conduction of heat across the layers of a coil, and the drift that it makes.
///
///   dT/dt = a d2T/dx2,  T = outer face's at x = thickness, dT/dx = 0 or T = inner face's at x = 0
///
/// By eigenfunctions, exact for face temperatures that change linearly over each step; the coil begins in equilibrium
/// with the first.
///
/// Accuracy  the series ends after 4 modes a layer: 1e-3/(layers) K of a step of 1 K after thickness^2/(100 a)
class CoilHeat {
 public:
  /// A coil in equilibrium with its faces. Given: temperatures of the outer and the inner face [K].
  CoilHeat(const Coil& coil, double outer, double inner);

  /// Goes on by `step` [s] to face temperatures `outer`, `inner` [K]; with an insulated inner face `inner` is not
  /// looked at.
  ///
  /// Returned  mean apparent rate over the step [rad/s]
  double advance(double step, double outer, double inner);

  /// Mean temperature of each layer [K].
  std::vector<double> layers() const;

 private:
  void choose_step(double step);
  double moment() const;

  Coil coil_;
  double gain_ = 0.0;  ///< rate for a change of the moment by 1 K m^2/s
  double outer_, inner_;
  std::vector<double> rate_;                     ///< decay of each mode [1/s]
  std::vector<double> from_outer_, from_inner_;  ///< of the departure of each mode for 1 K/s of a face [1]
  std::vector<double> amplitude_;                ///< [K]
  std::vector<double> mode_moment_;              ///< sum over layers of weight x mean of the mode [m^2]
  double outer_moment_ = 0.0, inner_moment_ = 0.0;
  double step_ = 0.0;
  std::vector<double> decay_, gained_;  ///< over one step
};

}  // namespace tumble::fiber_optic_gyro
