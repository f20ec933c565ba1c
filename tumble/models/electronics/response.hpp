#pragma once

#include <vector>

#include "tumble/models/model.hpp"

/// The stateful parts that instruments share, each a Response: blocks of evenly spaced samples are changed in place,
/// and the state is kept from block to block. Lengths of the blocks do not matter.
namespace tumble::electronics {

/// One response after the other; empty ones are skipped. Null when nothing remains.
Response in_series(std::vector<Response> stages);

/// y'' + 2 zeta w y' + w^2 y = w^2 u: a rebalance or servo loop, docs/equations (4.3).
///
/// The exact solution for an input that is a parabola through its last three samples, so that the steps may be longer
/// than the period of the loop. The loop has settled to the first sample when it begins.
///
/// Given     natural_frequency [Hz], damping_ratio [1], step [s], all > 0
/// Throws    Error::bad_input
/// Accuracy  exact in steady state for a constant, a ramp and a parabola; relative error of the gain of a sine of f:
///           below (2 pi f step)^4/24, of its phase below (2 pi f step)^3/12
/// See       Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slide 27; docs/equations (4.3)
Response second_order_loop(double natural_frequency, double damping_ratio, double step);

/// T y' + y = u, solved as second_order_loop does.
///
/// Given     time_constant [s], step [s], both > 0
/// Throws    Error::bad_input
Response first_order_loop(double time_constant, double step);

/// Samples beyond the limits [unit of the signal] are put on them. Throws Error::bad_input unless low < high.
Response clip(double low, double high);

/// Samples from low to high [unit of the signal] become 0, all others stay as they are. Throws Error::bad_input unless
/// low <= 0 <= high.
Response dead_zone(double low, double high);

/// Rounds to the nearest multiple of `quantum` [unit of the signal] (halves away from zero). Throws Error::bad_input
/// unless quantum > 0.
Response quantiser(double quantum);

/// Multiplies by `factor` [unit of the output per unit of the input].
Response scaled(double factor);

/// Whole pulses of each step, of both signs, from a rate of pulses:
///
///   N_j = floor(Phi(j step) + u) - floor(Phi((j-1) step) + u),  Phi the integral of the rate
///
/// Samples are the mean rate over their step. The total since the start is off by less than one pulse, however long.
///
/// Given     step [s], start_phase u in [0, 1): one for each power-up
/// See       Lu Hanjie, Liu Yabin, Zhou Qiang, 2019; docs/equations (3.3), (3.14)
Response pulse_counter(double step, double start_phase);

}  // namespace tumble::electronics
