#include "tumble/math/regression/local_polynomial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unsupported/Eigen/FFT>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Spectrum = std::vector<std::complex<double>>;

/// Fourier integral at k/T, first half; mean taken off.
Spectrum spectrum_of(std::span<const double> signal, double rate) {
  const double mean =
      std::accumulate(signal.begin(), signal.end(), 0.0) / static_cast<double>(std::max<std::size_t>(1, signal.size()));
  std::vector<double> moved(signal.begin(), signal.end());
  for (double& v : moved) v -= mean;
  Spectrum full;
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  fft.fwd(full, moved);
  for (auto& v : full) v /= rate;
  return full;
}

struct Lines {
  std::size_t first = 0, count = 0;
};

/// Lines of the spectrum within the band, at least `least`, kept inside of the excitation.
Lines lines_about(double f, double half, double bin, std::size_t lowest, std::size_t highest, std::size_t least) {
  if (highest < lowest) return {};
  const auto at = [&](double x) {
    return static_cast<std::size_t>(std::clamp(x / bin, static_cast<double>(lowest), static_cast<double>(highest)));
  };
  std::size_t first = at(f - half + bin), last = at(f + half);
  while (last - first + 1 < least && (first > lowest || last < highest)) {
    if (first > lowest) --first;
    if (last < highest) ++last;
  }
  return {first, last - first + 1};
}

BandResponse solve(const Spectrum& x, const Spectrum& y, double f, double half, double bin, Lines lines) {
  const Eigen::Index response_order = lines.count >= 24 ? 5 : 3, leak = 3, p = response_order + leak;
  const auto n = static_cast<Eigen::Index>(lines.count);
  BandResponse out;
  out.frequency = f;
  if (n < 11) return out;
  Eigen::MatrixXcd design(n, p);
  Eigen::VectorXcd observed(n);
  double in_power = 0.0, out_power = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t k = lines.first + static_cast<std::size_t>(i);
    const double r = (static_cast<double>(k) * bin - f) / half;
    double power = 1.0;
    for (Eigen::Index q = 0; q < response_order; ++q, power *= r) {
      design(i, q) = power * x[k];
      if (q < leak) design(i, response_order + q) = power;
    }
    observed[i] = y[k];
    in_power += std::norm(x[k]);
    out_power += std::norm(y[k]);
  }
  const Eigen::VectorXd scale = design.colwise().norm();
  if (!(scale.minCoeff() > 0.0) || !(out_power > 0.0)) return out;
  design = design * scale.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<Eigen::MatrixXcd> qr(design);
  const Eigen::VectorXcd b = qr.solve(observed);
  const double noise = (observed - design * b).squaredNorm() / static_cast<double>(n - p);
  const Eigen::MatrixXcd r = qr.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  Eigen::VectorXcd unit = Eigen::VectorXcd::Zero(p);
  unit[0] = 1.0;
  const double spread = r.adjoint().triangularView<Eigen::Lower>().solve(unit).squaredNorm();
  out.response = b[0] / scale[0];
  out.variance = noise * spread / std::norm(b[0]) / 2.0;
  out.degrees_of_freedom = 2.0 * static_cast<double>(n - p);
  out.coherence = std::clamp(1.0 - noise * static_cast<double>(n) / out_power, 0.0, 1.0);
  // Both halves of the spectrum: mean square = 2 sum |X|^2 bin / T, amplitude = sqrt(2 mean square), T = 1/bin.
  out.input_amplitude = 2.0 * std::sqrt(in_power) * bin;
  out.found = std::norm(b[0]) > 0.0;
  return out;
}

}  // namespace

std::vector<BandResponse> local_polynomial_response(std::span<const double> input, double input_rate,
                                                    std::span<const double> output, double output_rate,
                                                    std::span<const double> frequencies, double lowest, double highest,
                                                    double width) {
  const double time = static_cast<double>(input.size()) / input_rate;
  if (input.empty() || std::abs(static_cast<double>(output.size()) / output_rate - time) > 1e-6 * time)
    throw Error(Error::Kind::bad_input, fmt::format("local polynomial response: {:.9g} s of input, {:.9g} s of output",
                                                    time, static_cast<double>(output.size()) / output_rate));
  const Spectrum x = spectrum_of(input, input_rate), y = spectrum_of(output, output_rate);
  const double bin = 1.0 / time;
  const auto first = static_cast<std::size_t>(std::max(1.0, std::ceil(lowest / bin)));
  const auto last = std::min<std::size_t>({x.size() - 2, y.size() - 2, static_cast<std::size_t>(highest / bin)});
  std::vector<BandResponse> found;
  for (const double f : frequencies) {
    const double half = std::max(width * f, 6.0 * bin);
    found.push_back(solve(x, y, f, half, bin, lines_about(f, half, bin, first, last, 11)));
  }
  return found;
}

std::pair<double, double> occupied_band(std::span<const double> signal, double rate) {
  const Spectrum x = spectrum_of(signal, rate);
  double total = 0.0, sum = 0.0;
  for (const auto& v : x) total += std::norm(v);
  const double bin = rate / static_cast<double>(signal.size());
  double low = 0.0, high = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    sum += std::norm(x[k]);
    if (sum < 0.005 * total) low = static_cast<double>(k) * bin;
    if (sum < 0.995 * total) high = static_cast<double>(k) * bin;
  }
  return {low, high};
}

std::size_t smooth_length(std::size_t most, std::size_t multiple) {
  for (std::size_t n = most / multiple * multiple; n > 0; n -= multiple) {
    std::size_t rest = n;
    for (const std::size_t factor : {2u, 3u, 5u})
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return n;
  }
  return 0;
}

}  // namespace tumble
