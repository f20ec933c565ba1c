#include "tumble/methods/sine_vibration/line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::sine_vibration {
namespace {

using Complex = std::complex<double>;

constexpr std::size_t fewest_of_line = 32;    ///< windows, for a tone with its harmonics and their noise
constexpr std::size_t longest_run = 64;       ///< windows whose waves are products: their rounding is less than 1e-14
constexpr double even_windows_within = 1e-9;  ///< [windows] by which even windows may differ
constexpr double alternates_within = 1.6;     ///< [1/span] from half the rate: the harmonic is no line of its own there
/// Search for the frequency: the greatest step and the greatest way [1/span], within the main lobe, and the last step.
constexpr int most_rounds_of_search = 12;
constexpr double longest_search_step = 0.4, farthest_search = 1.2, last_search_step = 1e-6;
/// Neighbours of a tone [1/span] where its noise is measured; clear of the tone's image by one more than of other
/// lines.
constexpr int nearest_neighbour = 3, farthest_neighbour = 12;
constexpr double clear_of_image = 2.4;
constexpr std::size_t parts_of_tone = 400;        ///< of the demodulated tone: short against 1/(12/span)
constexpr double fewest_neighbour_squares = 8.0;  ///< of two each: with fewer the residual gives the noise

struct Samples {
  std::vector<double> time, value;  ///< time from the middle
  double span = 0.0, interval = 0.0;
};

Samples usable(std::span<const double> time, std::span<const double> value, double interval) {
  Samples s;
  s.interval = interval;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (std::isnan(value[i])) continue;
    s.time.push_back(time[i]);
    s.value.push_back(value[i]);
  }
  if (s.time.size() < fewest_of_line)
    throw Error(Error::Kind::bad_data, say("{} windows are too few for a tone", s.time.size()));
  const double first = s.time.front(), slack = stamp_slack(s.time.back(), interval);
  for (double& t : s.time) {  // of even windows without the rounding of their stamps
    const double even = std::round((t - first) / interval) * interval;
    t = std::abs(t - first - even) <= slack ? even : t - first;
  }
  const double centre = 0.5 * s.time.back();
  s.span = s.time.back() + interval;
  for (double& t : s.time) t -= centre;
  return s;
}

/// exp(i 2 pi f t), by products over runs of even windows.
void waves(const Samples& s, double frequency, std::vector<Complex>& out) {
  out.resize(s.time.size());
  const Complex turn = std::polar(1.0, two_pi * frequency * s.interval);
  for (std::size_t i = 0; i < s.time.size(); ++i) {
    const bool next =
        i % longest_run != 0 && std::abs(s.time[i] - s.time[i - 1] - s.interval) < even_windows_within * s.interval;
    out[i] = next ? out[i - 1] * turn : std::polar(1.0, std::fmod(frequency * s.time[i], 1.0) * two_pi);
  }
}

/// Least squares over columns made row by row.
struct Normal {
  Matrix inverse;
  std::vector<double> b;
};

template <class MakeRow>
Normal solve(const Samples& s, std::size_t columns, MakeRow make) {
  Matrix squares(columns, columns);  // lower triangle
  std::vector<double> products(columns, 0.0), row(columns), scale;
  for (std::size_t i = 0; i < s.time.size(); ++i) {
    make(i, row.data());
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t k = j; k < columns; ++k) squares(k, j) += row[j] * row[k];
      products[j] += row[j] * s.value[i];
    }
  }
  for (const double square : diagonal_of(squares)) scale.push_back(1.0 / std::sqrt(std::max(square, 1e-300)));
  squares = scaled_rows(scale, scaled_columns(std::move(squares), scale));
  return {scaled_rows(scale, scaled_columns(inverse_symmetric(squares), scale)),
          scaled(scale, solve_symmetric(squares, scaled(scale, products)))};
}

/// Harmonics that are distinct from the tone, from zero, from half of the rate and from each other.
std::vector<int> harmonics_of(const Samples& s, double frequency) {
  const double rate = 1.0 / s.interval, clear = 1.6 / s.span;
  std::vector<double> lines{aliased_frequency(frequency, rate)};
  std::vector<int> harmonics;
  for (const int k : {2, 3}) {
    const double here = aliased_frequency(k * frequency, rate);
    if (here < clear || here > 0.5 * rate - clear) continue;
    if (std::ranges::any_of(lines, [&](double f) { return std::abs(f - here) < clear; })) continue;
    lines.push_back(here);
    harmonics.push_back(k);
  }
  return harmonics;
}

/// Whether a harmonic falls upon half of the windows a second, where sine and cosine are one: it changes sign from
/// window to window. In the residuals it would be c/n of the mean over an odd number of windows.
bool alternates(const Samples& s, double frequency) {
  const double rate = 1.0 / s.interval;
  return std::ranges::any_of(std::array{2, 3}, [&](int k) {
    return aliased_frequency(k * frequency, rate) > 0.5 * rate - alternates_within / s.span;
  });
}

/// 1, -1, 1, ...
double alternating(const Samples& s, std::size_t i) {
  return std::fmod(std::round((s.time[i] - s.time.front()) / s.interval), 2.0) == 0.0 ? 1.0 : -1.0;
}

Complex power(Complex w, int k) { return k == 2 ? w * w : w * w * w; }

/// One step of the frequency: amplitude and phase may change linearly with time.
double step_of_frequency(const Samples& s, const std::vector<Complex>& wave, const std::vector<int>& harmonics,
                         bool alternates) {
  const double scale = 2.0 / s.span;
  const std::size_t last = 6 + 2 * harmonics.size();
  const Normal fit = solve(s, last + (alternates ? 2 : 0), [&](std::size_t i, double* x) {
    const double u = s.time[i] * scale;
    x[0] = 1.0, x[1] = u, x[2] = wave[i].real(), x[3] = wave[i].imag(), x[4] = u * x[2], x[5] = u * x[3];
    for (std::size_t h = 0; h < harmonics.size(); ++h) {
      const Complex w = power(wave[i], harmonics[h]);
      x[6 + 2 * h] = w.real(), x[7 + 2 * h] = w.imag();
    }
    if (alternates) x[last] = alternating(s, i), x[last + 1] = x[last] * u;
  });
  const Complex still(fit.b[2], -fit.b[3]), moving(fit.b[4], -fit.b[5]);
  return (moving / still).imag() * scale / two_pi;
}

struct Model {
  std::vector<int> harmonics;
  bool alternates = false;  ///< two last columns: 1, -1, 1, ... and that times time
  Normal fit;
  double frequency = 0.0;
  std::vector<Complex> wave;
};

Complex coefficient(const Model& m, std::size_t line) {
  const std::size_t k = 2 + 2 * line;
  return {m.fit.b[k], -m.fit.b[k + 1]};
}

double search(const Samples& s, double start, std::vector<Complex>& wave) {
  double f = start;
  for (int round = 0; round < most_rounds_of_search; ++round) {
    waves(s, f, wave);
    const double step =
        std::clamp(step_of_frequency(s, wave, {}, false), -longest_search_step / s.span, longest_search_step / s.span);
    f += step;
    if (!(std::abs(f - start) * s.span < farthest_search))
      throw Error(Error::Kind::bad_data, say("no steady tone near {:.6g} Hz", start));
    if (std::abs(step) * s.span < last_search_step) break;
  }
  return f;
}

Model model_of(const Samples& s, double frequency) {
  Model m;
  m.frequency = search(s, frequency, m.wave);
  waves(s, m.frequency, m.wave);
  m.harmonics = harmonics_of(s, m.frequency);
  m.alternates = alternates(s, m.frequency);
  if (!m.harmonics.empty() || m.alternates) {
    m.frequency += step_of_frequency(s, m.wave, m.harmonics, m.alternates);
    waves(s, m.frequency, m.wave);
  }
  const double scale = 2.0 / s.span;
  const std::size_t last = 4 + 2 * m.harmonics.size(), columns = last + (m.alternates ? 2 : 0);
  m.fit = solve(s, columns, [&](std::size_t i, double* x) {
    const Complex w = m.wave[i];
    x[0] = 1.0, x[1] = s.time[i] * scale, x[2] = w.real(), x[3] = w.imag();
    for (std::size_t h = 0; h < m.harmonics.size(); ++h) {
      const Complex line = power(w, m.harmonics[h]);
      x[4 + 2 * h] = line.real(), x[5 + 2 * h] = line.imag();
    }
    if (m.alternates) x[last] = alternating(s, i), x[last + 1] = x[last] * x[1];
  });
  return m;
}

double predicted(const Samples& s, const Model& m, std::size_t i) {
  double value = m.fit.b[0] + m.fit.b[1] * s.time[i] * 2.0 / s.span + (coefficient(m, 0) * m.wave[i]).real();
  for (std::size_t h = 0; h < m.harmonics.size(); ++h)
    value += (coefficient(m, h + 1) * power(m.wave[i], m.harmonics[h])).real();
  if (m.alternates) {
    const std::size_t last = m.fit.b.size() - 2;
    value += alternating(s, i) * (m.fit.b[last] + m.fit.b[last + 1] * s.time[i] * 2.0 / s.span);
  }
  return value;
}

/// Offsets +- m/T from the tone [Hz] that are clear of its image, zero, half of the rate and the harmonics.
std::vector<double> neighbours(const Samples& s, double frequency, const std::vector<int>& harmonics) {
  const double rate = 1.0 / s.interval, bin = 1.0 / s.span, here = aliased_frequency(frequency, rate);
  std::vector<double> offsets;
  for (int m = nearest_neighbour; m <= farthest_neighbour; ++m)
    for (const double side : {-1.0, 1.0}) {
      const double g = aliased_frequency(frequency + side * m * bin, rate);
      bool clear =
          g > clear_of_line * bin && g < 0.5 * rate - clear_of_line * bin && std::abs(g - here) > clear_of_image * bin;
      for (const int k : harmonics)
        clear = clear && std::abs(g - aliased_frequency(k * frequency, rate)) > clear_of_line * bin;
      if (clear) offsets.push_back(side * m * bin);
    }
  return offsets;
}

/// Variance of a sample of white noise with the density about the line; demodulated in parts short against 1/(12/T).
void set_noise(const Samples& s, const Model& m, const std::vector<double>& residual, Line& line) {
  const std::size_t n = residual.size(), parts = std::min<std::size_t>(parts_of_tone, n);
  std::vector<Complex> sum(parts);
  std::vector<double> middle(parts);
  for (std::size_t p = 0; p < parts; ++p) {
    const std::size_t first = p * n / parts, last = (p + 1) * n / parts;
    for (std::size_t i = first; i < last; ++i) sum[p] += residual[i] * std::conj(m.wave[i]);
    middle[p] = 0.5 * (s.time[first] + s.time[last - 1]);
  }
  double squares = 0.0, count = 0.0;
  for (const double offset : neighbours(s, m.frequency, m.harmonics)) {
    Complex neighbour = 0.0;
    for (std::size_t p = 0; p < parts; ++p) neighbour += sum[p] * std::polar(1.0, -two_pi * offset * middle[p]);
    squares += std::norm(neighbour) * 2.0 / static_cast<double>(n);
    count += 2.0;
  }
  double variance = line.residual_rms * line.residual_rms;
  line.noise_degrees_of_freedom = static_cast<double>(n);
  if (count >= fewest_neighbour_squares) {
    variance = squares / count;
    line.noise_degrees_of_freedom = count;
  }
  const Complex a = coefficient(m, 0);
  const double c = a.real() / std::norm(a), d = -a.imag() / std::norm(a);
  const auto& v = m.fit.inverse;
  line.log_variance = variance * (c * c * v(2, 2) + 2.0 * c * d * v(2, 3) + d * d * v(3, 3));
  // The frequency is 1/(pi T) sqrt(6/n) of noise over amplitude (Cramer-Rao).
  line.frequency_sd = std::sqrt(6.0 * variance / static_cast<double>(n)) / (pi * s.span * std::abs(a));
}

void set_blocks(const std::vector<double>& residual, double interval, Line& line) {
  constexpr std::size_t blocks = 16;
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t first = b * residual.size() / blocks, last = (b + 1) * residual.size() / blocks;
    double sum = 0.0;
    for (std::size_t i = first; i < last; ++i) sum += residual[i];
    const double n = static_cast<double>(last - first);
    line.block_mean.push_back(line.mean + sum / n);
    line.block_seconds.push_back(n * interval);
  }
}

void set_moments(const Samples& s, Line& line) {
  const double n = static_cast<double>(s.value.size());
  double sum = 0.0, squares = 0.0;
  for (const double v : s.value) sum += v;
  line.plain_mean = sum / n;
  for (const double v : s.value) squares += (v - line.plain_mean) * (v - line.plain_mean);
  line.sd = std::sqrt(squares / (n - 1.0));
  line.samples = s.value.size();
  line.span = s.span;
}

/// The residuals in the places of their values.
void set_residual(std::span<const double> value, const std::vector<double>& residual, Line& line) {
  line.residual.assign(value.size(), std::nan(""));
  std::size_t next = 0;
  for (std::size_t i = 0; i < value.size(); ++i)
    if (!std::isnan(value[i])) line.residual[i] = residual[next++];
}

void set_rms(const std::vector<double>& residual, Line& line) {
  double squares = 0.0;
  for (const double r : residual) squares += r * r;
  line.residual_rms = std::sqrt(squares / static_cast<double>(residual.size()));
}

}  // namespace

Line fit_line(std::span<const double> time, std::span<const double> value, double interval, double frequency) {
  const Samples s = usable(time, value, interval);
  Line line;
  set_moments(s, line);
  const Model m = model_of(s, frequency);
  line.frequency = m.frequency;
  const Complex a = coefficient(m, 0);
  line.amplitude = std::abs(a);
  line.phase = std::arg(a);
  line.mean = m.fit.b[0];
  line.drift = m.fit.b[1] * 2.0 / s.span;
  line.second = line.third = std::nan("");
  for (std::size_t h = 0; h < m.harmonics.size(); ++h)
    (m.harmonics[h] == 2 ? line.second : line.third) = std::abs(coefficient(m, h + 1));
  std::vector<double> residual(s.value.size());
  for (std::size_t i = 0; i < residual.size(); ++i) residual[i] = s.value[i] - predicted(s, m, i);
  set_rms(residual, line);
  set_residual(value, residual, line);
  set_noise(s, m, residual, line);
  set_blocks(residual, interval, line);
  return line;
}

Line fit_rest(std::span<const double> time, std::span<const double> value, double interval) {
  const Samples s = usable(time, value, interval);
  Line line;
  set_moments(s, line);
  const Normal fit = solve(s, 2, [&](std::size_t i, double* x) { x[0] = 1.0, x[1] = s.time[i] * 2.0 / s.span; });
  line.mean = fit.b[0];
  line.drift = fit.b[1] * 2.0 / s.span;
  std::vector<double> residual(s.value.size());
  for (std::size_t i = 0; i < residual.size(); ++i) residual[i] = s.value[i] - line.mean - line.drift * s.time[i];
  set_rms(residual, line);
  set_residual(value, residual, line);
  set_blocks(residual, interval, line);
  return line;
}

}  // namespace tumble::sine_vibration
