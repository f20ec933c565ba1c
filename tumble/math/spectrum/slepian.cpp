#include "tumble/math/spectrum/slepian.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "tumble/math/fourier.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// [1] of the bound; of the distance to the next.
constexpr double eigenvalue_rounding = 1e-14, eigenvalue_within = 1e-4;

/// Symmetric: diagonal d_0 ... d_{N-1}, beside it e_1 ... e_{N-1} (e_0 is zero).
struct Tridiagonal {
  std::vector<double> d, e;
};

Tridiagonal commuting_matrix(std::size_t length, double bandwidth) {
  Tridiagonal matrix{std::vector<double>(length), std::vector<double>(length)};
  const double n = static_cast<double>(length), cosine = std::cos(two_pi * bandwidth);
  for (std::size_t i = 0; i < length; ++i) {
    const double t = static_cast<double>(i), from_middle = 0.5 * (n - 1.0 - 2.0 * t);
    matrix.d[i] = from_middle * from_middle * cosine;
    matrix.e[i] = 0.5 * t * (n - t);
  }
  return matrix;
}

/// How many eigenvalues lie above `value`: positive pivots of T - value.
std::size_t above(const Tridiagonal& matrix, double value) {
  std::size_t count = 0;
  double pivot = 1.0;
  for (std::size_t i = 0; i < matrix.d.size(); ++i) {
    pivot = matrix.d[i] - value - matrix.e[i] * matrix.e[i] / pivot;
    if (pivot == 0.0) pivot = -1e-30;
    count += pivot > 0.0 ? 1 : 0;
  }
  return count;
}

/// The eigenvalue with `before` greater ones, nearer than its neighbours by 1e-4 of their distance or more.
double eigenvalue(const Tridiagonal& matrix, std::size_t before) {
  double bound = 0.0;
  for (std::size_t i = 0; i < matrix.d.size(); ++i) {
    const double next = i + 1 < matrix.d.size() ? matrix.e[i + 1] : 0.0;
    bound = std::max(bound, std::abs(matrix.d[i]) + matrix.e[i] + next);
  }
  double low = -bound, high = bound;
  while (high - low > eigenvalue_rounding * bound + eigenvalue_within) {
    const double middle = 0.5 * (low + high);
    (above(matrix, middle) > before ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Solves (T - shift) x = b by elimination with row exchanges.
class ShiftedSolver {
 public:
  ShiftedSolver(const Tridiagonal& matrix, double shift)
      : diagonal_(matrix.d), upper_(matrix.d.size(), 0.0), second_(upper_), factor_(upper_), swapped_(upper_.size()) {
    const std::size_t size = diagonal_.size();
    for (double& value : diagonal_) value -= shift;
    for (std::size_t i = 0; i + 1 < size; ++i) upper_[i] = matrix.e[i + 1];
    for (std::size_t i = 0; i + 1 < size; ++i) {
      double below = matrix.e[i + 1];
      swapped_[i] = std::abs(below) > std::abs(diagonal_[i]);
      if (swapped_[i]) {
        std::swap(diagonal_[i], below);
        std::swap(upper_[i], diagonal_[i + 1]);
        std::swap(second_[i], upper_[i + 1]);
      }
      if (diagonal_[i] == 0.0) diagonal_[i] = 1e-30;
      factor_[i] = below / diagonal_[i];
      diagonal_[i + 1] -= factor_[i] * upper_[i];
      upper_[i + 1] -= factor_[i] * second_[i];
    }
    if (diagonal_[size - 1] == 0.0) diagonal_[size - 1] = 1e-30;
  }

  void solve(std::vector<double>& x) const {
    const std::size_t size = x.size();
    for (std::size_t i = 0; i + 1 < size; ++i) {
      if (swapped_[i]) std::swap(x[i], x[i + 1]);
      x[i + 1] -= factor_[i] * x[i];
    }
    for (std::size_t i = size; i-- > 0;) {
      if (i + 1 < size) x[i] -= upper_[i] * x[i + 1];
      if (i + 2 < size) x[i] -= second_[i] * x[i + 2];
      x[i] /= diagonal_[i];
    }
  }

 private:
  std::vector<double> diagonal_, upper_, second_, factor_;
  std::vector<bool> swapped_;
};

void normalise(std::vector<double>& x) {
  double largest = 0.0, squares = 0.0;
  for (const double value : x) largest = std::max(largest, std::abs(value));
  for (double& value : x) {
    value /= largest;
    squares += value * value;
  }
  for (double& value : x) value /= std::sqrt(squares);
}

/// Symmetric about the middle for an even order, antisymmetric for an odd one, and of the usual sign.
void shape(std::vector<double>& x, std::size_t order) {
  const double parity = order % 2 == 0 ? 1.0 : -1.0;
  double sign = 0.0;
  for (std::size_t i = 0; i < x.size() / 2; ++i) {
    const std::size_t mirrored = x.size() - 1 - i;
    x[i] = 0.5 * (x[i] + parity * x[mirrored]);
    x[mirrored] = parity * x[i];
    sign += x[i] * (order % 2 == 0 ? 1.0 : static_cast<double>(mirrored - i));
  }
  if (x.size() % 2 == 1) {
    double& middle = x[x.size() / 2];
    middle = order % 2 == 0 ? middle : 0.0;
    sign += 0.5 * middle;
  }
  if (sign < 0.0)
    for (double& value : x) value = -value;
}

/// sum_ij v_i v_j sin(2 pi W (i - j))/(pi (i - j)), through the autocorrelation of v.
double concentration(const std::vector<double>& v, double bandwidth) {
  const std::size_t size = v.size();
  std::vector<double> padded(2 * size, 0.0);
  std::copy(v.begin(), v.end(), padded.begin());
  std::vector<std::complex<double>> spectrum;
  real_transform(padded, spectrum);
  // The autocorrelation is even, so a forward transform of the even power spectrum brings it back.
  for (std::size_t k = 0; k <= size; ++k) padded[k] = padded[(2 * size - k) % (2 * size)] = std::norm(spectrum[k]);
  real_transform(padded, spectrum);
  double sum = 2.0 * bandwidth * spectrum[0].real();
  for (std::size_t lag = 1; lag < size; ++lag) {
    const double t = pi * static_cast<double>(lag);
    sum += 2.0 * spectrum[lag].real() * std::sin(2.0 * bandwidth * t) / t;
  }
  return sum / static_cast<double>(2 * size);
}

}  // namespace

std::vector<SlepianTaper> slepian_tapers(std::size_t length, double time_bandwidth, std::size_t count) {
  Problems problems;
  if (length < 2) problems.push_back("a taper needs a length of 2 samples or more");
  if (!(time_bandwidth > 0.0 && time_bandwidth < 0.5 * static_cast<double>(length)))
    problems.push_back("time-bandwidth must lie between 0 and half the length of the taper");
  if (count > length) problems.push_back("there are not more tapers than samples");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  const double bandwidth = time_bandwidth / static_cast<double>(length);
  const Tridiagonal matrix = commuting_matrix(length, bandwidth);
  std::vector<SlepianTaper> tapers(count);
  for (std::size_t k = 0; k < count; ++k) {
    auto& x = tapers[k].values;
    const ShiftedSolver solver(matrix, eigenvalue(matrix, k));
    // Neither symmetric nor antisymmetric, and orthogonal to none.
    x.resize(length);
    for (std::size_t i = 0; i < length; ++i) x[i] = 1.0 + std::sin(1.0 + 1.7 * static_cast<double>(i));
    for (int round = 0; round < 4; ++round) {
      solver.solve(x);
      normalise(x);
    }
    shape(x, k);
    normalise(x);
    tapers[k].concentration = concentration(x, bandwidth);
  }
  return tapers;
}

}  // namespace tumble
