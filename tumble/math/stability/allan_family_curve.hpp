#pragma once

#include <span>
#include <vector>

#include "tumble/math/stability/allan.hpp"
#include "tumble/math/stability/allan_family.hpp"

namespace tumble {

/// A stability measure of a rate signal over log-spaced averaging times, in a time that long records allow.
///
/// Measures whose time goes with N m are taken, from m = 32 on, of block means of 16 and more to each tau: of the phase
/// (modified and time total), of the rate (Hadamard total, Theo1). These are fewer of the same terms, of which there
/// are 16 a tau still. ThêoH beyond a tenth of the record comes from means of the rate, 4096 of the record (Taylor and
/// Howe, Fast TheoBR, IEEE Trans. UFFC 57 (2010) 2079). Up to m = 31 they are `stability_of_rate`.
///
/// Given     rate   [u]; NaN: missing; sample_rate [Hz]
///           known  points with noise types, ascending, such as of `overlapping_allan`: each tau has that of the last
///                  one not beyond it
///           options  longest_fraction holds for all but those made for long tau: total deviations and interval
///                    errors go up to a half (third: modified, Hadamard), Theo1 and ThêoH up to three quarters
/// Throws    as stability_of_rate
std::vector<DeviationPoint> stability_curve(Stability measure, std::span<const double> rate, double sample_rate,
                                            const AllanOptions& options, std::span<const DeviationPoint> known);

}  // namespace tumble
