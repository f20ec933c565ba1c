#pragma once

namespace tumble {

/// Average number of points to the first alarm of an EWMA chart of independent standard normal points: weight `lambda`
/// [1] in (0, 1] of the newest, limits +-L sqrt(lambda/(2 - lambda)) [sd], mean shifted by `shift` [sd].
/// Accuracy: integral equation by 80 Gauss-Legendre nodes, five digits. See: docs/equations (8.32).
double run_length_of_ewma(double lambda, double limit, double shift = 0.0);

/// Average number of points to the first alarm of a two-sided CUSUM with reference `k` [sd] and decision limit `h`
/// [sd].
double run_length_of_cusum(double k, double h, double shift = 0.0);

/// Limit L or h that gives this average run length [points] without a shift. Throws Error::bad_input below 2 points or
/// for a lambda or k out of range.
double limit_of_ewma(double lambda, double run_length);
double limit_of_cusum(double k, double run_length);

}  // namespace tumble
