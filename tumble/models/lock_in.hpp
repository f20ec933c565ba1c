#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tumble/math/random.hpp"

namespace tumble {

/// The coupling of the two beams of a ring laser.
struct LockIn {
  double scale_factor = 0.0;  ///< K [fringe/rad]
  double rate = 0.0;          ///< W_L [rad/s], half width of the dead band without dither; 0: none
};

/// Rotation of the block against the case, W_A sin(2 pi f_D t), docs/equations (4.25). With noise the angle of every
/// turn-around differs from W_A/(2 pi f_D) by a normal number of its own; half a cosine joins one to the next.
struct Dither {
  double rate = 0.0;       ///< W_A [rad/s]; 0: no dither
  double frequency = 0.0;  ///< f_D [Hz]
  double noise = 0.0;      ///< sd of the angle of a turn-around, relative to the angle
};

/// The beat phase psi of a ring laser gyro,
///
///   d psi/dt = 2 pi K [W(t) - W_L sin psi],   W = w_i + dither                                              (4.24)
///
/// with the input rate w_i constant over each step. Without dither the solution is exact. White noise of the input is
/// not constant over a step: it acts where psi almost stops (4.33) and leaves the mean rate as it is, while a constant
/// rate acts like another rate. A step with noise is therefore divided into parts with an impulse of noise in the
/// middle of each; the mean over the step remains as it is given. With dither, psi is the known phase of the rotation
/// plus a slow part, and e^{i psi} = u/conj(u) makes the equation linear, u' = i a/2 u + e/2 conj(u) with a = 2 pi K W,
/// e = 2 pi K W_L. It is stepped by turning with the exact phase and applying the coupling at the middle of steps of h
/// (second-order splitting): the phase is turned by (1 - (e h)^2/24) of itself, which removes the second-order error
/// that accumulates, and the error that remains at first order in e falls exponentially once a h < pi, as for any
/// trapezoidal sum over a period. Steps are short enough that a h < 2, e h < 0.05 and h < 1/(256 f_D).
///
/// Accuracy  mean output rate over 0.1 s or more within 1e-6 W_L (bench/results/lock_in.md)
class BeatPhase {
 public:
  /// Given  start  angle at time 0 [fringe]; the turn-arounds of a noisy dither are drawn from `random`
  ///        white  variance N^2 of the input's white noise [rad^2/s], of which the rates that are given are means over
  ///               their steps; not looked at with dither, which is far larger
  BeatPhase(const LockIn& lock_in, const Dither& dither, double start, const RandomStream& random, double white = 0.0);

  /// Given     step [s]; rate, mean input rate over each step [rad/s]
  /// Returned  fringes, psi/(2 pi) less the dither's own phase, at the end of each step: what a readout fixed to the
  ///           case sees; the fringes of a readout on the block are these plus dither_fringes()
  void advance(double step, std::span<const double> rate, std::span<double> fringes);

  double fringes() const { return turns_ + (input_ + slow_); }  ///< as advance() returned them last [fringe]
  double dither_fringes() const;                                ///< K times the dither's angle now [fringe]
  std::uint64_t steps() const { return steps_; }                ///< taken so far, of those that resolve the dither

 private:
  void advance_free(double step, double rate);
  void advance_noisy(double step, double rate);
  void advance_dithered(double step, double rate);
  std::size_t kick(double h, double turns_a_step, std::size_t most);
  void choose_table(double h);
  void next_half_cycle();

  static constexpr std::size_t batch = 64;
  LockIn lock_in_;
  Dither dither_;
  RandomStream random_;
  double white_;                         ///< N^2 [rad^2/s]
  std::vector<double> noise_;            ///< of the parts of a step [1]
  std::uint64_t drawn_ = 0;              ///< numbers of it so far
  double input_ = 0.0;                   ///< phase of the input [turns], its whole turns apart
  double turns_ = 0.0;                   ///< whole turns of the input
  double real_ = 1.0, imaginary_ = 0.0;  ///< u, turned back by half of the known phase
  double slow_ = 0.0;                    ///< psi less the known phase [turns]
  double half_cycles_ = 0.0;             ///< of the dither, since `half_cycle_`
  std::uint64_t half_cycle_ = 0;
  double offset_ = 0.0, swing_ = 0.0;         ///< of the dither's angle in this half cycle [turns]
  double last_turn_ = 0.0, next_turn_ = 0.0;  ///< departure of the turn-around before and after [turns]
  std::uint64_t steps_ = 0;
  double table_h_ = 0.0, cosh_ = 1.0, sinh_ = 0.0, shrink_ = 1.0;
  std::size_t longest_ = batch;
  std::array<double, batch> table_cosine_{}, table_sine_{};
};

/// Mean output rate [rad/s] after a long time under a constant input rate and a dither without noise: from the rotation
/// number of one dither period, so that lock zones are flat. dither.noise is not looked at.
double mean_output_rate(const LockIn& lock_in, const Dither& dither, double input_rate);

}  // namespace tumble
