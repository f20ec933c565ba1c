#pragma once

#include "tumble/models/lock_in.hpp"

namespace tumble {

/// Peak excursion of the beat phase under the dither [rad], x = K W_A/f_D.                                  (4.26)
double phase_excursion(const LockIn& lock_in, const Dither& dither);

/// Random walk of the angle that is left of lock-in when every turn-around of the dither finds a random phase.
///
///   N = W_L/sqrt(2 pi K W_A)   [rad/sqrt(s)]                                                              (4.27)
///
/// Valid  while one crossing of zero rate moves the phase little, 2 pi W_L sqrt(K/(2 pi f_D W_A)) << 1, and the noise
/// of
///        the dither moves the phase of a turn-around by much more than a turn
double angle_random_walk_from_lock_in(const LockIn& lock_in, const Dither& dither);

/// The envelope of the lock zones of a dither without noise [rad/s], W_R = W_L sqrt(2 f_D/(pi K W_A)).      (4.26)
double residual_lock_in_rate(const LockIn& lock_in, const Dither& dither);

/// A range of input rates that all give one output rate, under a sine dither without noise.
struct LockZone {
  double centre = 0.0;      ///< w_n = n f_D/K [rad/s], the output inside
  double half_width = 0.0;  ///< W_n = W_L |J_n(x)| [rad/s]
  double pull = 0.0;        ///< p, by which the other zones shift this one: it is centred at w_n - p [rad/s]
};

/// Zone number n.                                                                                           (4.26)
///
///   p = -sum_{m != n} W_m^2/(2 (w_i - w_m))  at w_i = w_n
///
/// Valid  for K W_L/f_D << 1; to 0.4 where x >= 30
LockZone lock_zone(const LockIn& lock_in, const Dither& dither, int n);

/// Output rate near the zone [rad/s]: its centre inside, w_n + sign(d) sqrt(d^2 - W_n^2) outside, with
/// d = w_i - w_n + p(w_i).                                                                                  (4.26)
double output_near_zone(const LockIn& lock_in, const Dither& dither, int n, double input_rate);

}  // namespace tumble
