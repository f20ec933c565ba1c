#pragma once

#include <complex>
#include <span>
#include <vector>

namespace tumble {

/// X_k = sum_n x_n exp(-2 pi i k n/N), k = 0 ... N/2, of real values.
/// Given: x [u], N values. Returned in `spectrum`: N/2 + 1 values [u].
void real_transform(std::span<const double> x, std::vector<std::complex<double>>& spectrum);

}  // namespace tumble
