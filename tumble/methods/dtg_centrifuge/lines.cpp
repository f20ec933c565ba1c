#include "tumble/methods/dtg_centrifuge/lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/methods/dtg_centrifuge/angles.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Columns = Eigen::Matrix<double, columns, 1>;
using Gram = Eigen::Matrix<double, columns, columns>;

constexpr std::size_t parts = 16;
constexpr std::size_t chunk = 4096;

Gram gram_of(const Sums& sums) {
  Gram gram;
  std::size_t k = 0;
  for (std::size_t a = 0; a < columns; ++a)
    for (std::size_t b = a; b < columns; ++b) {
      const auto i = static_cast<Eigen::Index>(a), j = static_cast<Eigen::Index>(b);
      gram(i, j) = gram(j, i) = sums.gram[k++];
    }
  return gram;
}

Columns moment_of(const Sums& sums, std::size_t signal) { return Columns::Map(sums.moment[signal].data()); }

/// The phasors of one fit: coefficients of cosine and sine, Z = cosine - i sine.
Phasors phasors_of(const Columns& b) {
  return {{Complex(b[2], -b[3]), Complex(b[4], -b[5]), Complex(b[6], -b[7])}, Complex(b[8], -b[9])};
}

struct Solver {
  Columns scale;
  Eigen::LLT<Gram> root;
  double weakest = 0.0;

  explicit Solver(const Gram& gram) {
    for (Eigen::Index k = 0; k < scale.size(); ++k) scale[k] = gram(k, k) > 0.0 ? 1.0 / std::sqrt(gram(k, k)) : 0.0;
    const Gram correlation = scale.asDiagonal() * gram * scale.asDiagonal();
    weakest = Eigen::SelfAdjointEigenSolver<Gram>(correlation, Eigen::EigenvaluesOnly).eigenvalues()[0];
    root.compute(correlation);
  }
  Columns solve(const Columns& moment) const { return scale.cwiseProduct(root.solve(scale.cwiseProduct(moment))); }
};

/// The signals that are recorded on one clock, and their sums over each part of the stretch.
struct Group {
  std::vector<Signal> signals;
  std::array<Sums, parts> sums;
  double expected = 0.0;  ///< samples
};

bool one_clock(const Channel& a, const Channel& b) {
  if (a.values.size() != b.values.size()) return false;
  if (a.timeline.uniform() && b.timeline.uniform())
    return a.timeline.start == b.timeline.start && a.timeline.rate == b.timeline.rate;
  return a.timeline.stamps == b.timeline.stamps;
}

void add_up(const Channels& channels, const Spin& stretch, const Angles& angles, Group& group) {
  const Channel& clock = *channels.signal[group.signals.front()];
  const double step = 1.0 / mean_rate(clock), length = stretch.end - stretch.begin, slack = 1e-6 * step;
  std::vector<double> work;
  for (std::size_t k = 0; k < parts; ++k) {
    const auto edge = [&](std::size_t n) {
      return index_at(clock, stretch.begin + length * static_cast<double>(n) / parts - slack);
    };
    const std::size_t first = edge(k);
    std::size_t last = std::min(edge(k + 1), clock.values.size());
    // the last sample's interval ends with the stretch
    while (k + 1 == parts && last > first && clock.time(last - 1) + step > stretch.end + slack) --last;
    for (std::size_t at = first; at < last; at += chunk) {
      Block block{.signals = group.signals.size(), .samples = std::min(chunk, last - at)};
      angles.at(clock, at, block.samples, work, block.arm, block.table);
      for (std::size_t s = 0; s < block.signals; ++s)
        block.signal[s] = channels.signal[group.signals[s]]->values.data() + at;
      block.tau = 2.0 * (clock.time(at) - stretch.begin) / length - 1.0;
      block.tau_step = 2.0 * step / length;
      add_to(group.sums[k], block);
    }
  }
  group.expected = std::floor(length / step + 1e-3);
}

std::vector<Group> groups_of(const Channels& channels) {
  std::vector<Group> groups;
  for (const Signal s : {gyro, reference, gyro_y}) {
    const Channel* channel = channels.signal[s];
    if (channel == nullptr) continue;
    const auto same = std::ranges::find_if(
        groups, [&](const Group& g) { return one_clock(*channels.signal[g.signals.front()], *channel); });
    (same == groups.end() ? *groups.insert(groups.end(), Group{}) : *same).signals.push_back(s);
  }
  return groups;
}

void scale(Phasors& p, const std::array<Complex, 3>& line, Complex earth) {
  for (std::size_t h = 0; h < 3; ++h) p.line[h] /= line[h];
  p.earth /= earth;
}

/// The fit follows the parts, so that they scatter less about it than their noise: of the variance of column j a share
/// h_j = [N^-1 SUM N_m N^-1 N_m N^-1]_jj/[N^-1]_jj is lost, 1/M where all parts are alike, more where they hold less
/// than a period. Factor that leaves 1/M lost, for cosine and sine of a line together.
Columns inflation_of(const Group& group, const Solver& solver) {
  const auto inverse_times = [&](const Gram& m) {
    Gram out;
    for (Eigen::Index c = 0; c < m.cols(); ++c) out.col(c) = solver.solve(m.col(c));
    return out;
  };
  Gram lost = Gram::Zero();
  double used = 0.0;
  for (const Sums& sums : group.sums) {
    if (!(sums.samples > 0.0)) continue;
    const Gram one = gram_of(sums);
    lost += one * inverse_times(one);
    used += 1.0;
  }
  const Gram inverse = inverse_times(Gram::Identity()), of_inverse = inverse_times(inverse_times(lost).transpose());
  Columns factor = Columns::Ones();
  for (Eigen::Index j = 2; j + 1 < factor.size(); j += 2) {
    const double h = (of_inverse(j, j) + of_inverse(j + 1, j + 1)) / (inverse(j, j) + inverse(j + 1, j + 1));
    if (used > 1.0 && h < 0.9) factor[j] = factor[j + 1] = std::sqrt((1.0 - 1.0 / used) / (1.0 - h));
  }
  return factor;
}

/// Least squares over all parts, and what each part adds: b_m = b + (n/n_m) N^-1 (g_m - N_m b).
// NOLINTNEXTLINE(readability-function-size): 41 lines; to be split when it changes
void solve(const Group& group, const Instruments& instruments, Measured& measured, const Channels& channels) {
  Sums all;
  for (const Sums& sums : group.sums) all += sums;
  const Gram gram = gram_of(all);
  const bool enough = all.samples > 4.0 * columns;
  const Solver solver(gram);
  if (!enough || !(solver.weakest > 1e-6)) {
    measured.weakest = 0.0;
    return;
  }
  measured.weakest = std::min(measured.weakest, solver.weakest);
  const Columns inflation = inflation_of(group, solver);
  for (std::size_t k = 0; k < group.signals.size(); ++k) {
    Lines& lines = measured.of[group.signals[k]];
    const Columns moment = moment_of(all, k), b = solver.solve(moment);
    lines.present = true;
    lines.step = 1.0 / mean_rate(*channels.signal[group.signals[k]]);
    lines.value = phasors_of(b);
    lines.mean = b[0];
    lines.samples = all.samples;
    lines.lost = std::max(0.0, group.expected - all.samples);
    lines.residual_sd = std::sqrt(std::max(0.0, all.square[k] - b.dot(moment)) / (all.samples - columns));
    std::array<Complex, 3> gain;
    const Channelling& electronics = instruments.of[group.signals[k]];
    for (std::size_t h = 0; h < 3; ++h)
      gain[h] = electronics.gain(static_cast<double>(h + 1) * measured.theta_rate(), lines.step);
    const Complex of_earth = electronics.gain(measured.beta_rate(), lines.step);
    if (std::abs(gain[0]) < 0.1) measured.fault = "averaging over a sample and the loop leave nothing of the line";
    for (std::size_t m = 0; m < parts; ++m) {
      const Sums& sums = group.sums[m];
      Phasors part;
      if (sums.samples > 0.0) {
        const Columns extra = solver.solve(moment_of(sums, k) - gram_of(sums) * b) * (all.samples / sums.samples);
        part = phasors_of(b + inflation.cwiseProduct(extra));
        scale(part, gain, of_earth);
      }
      lines.part.push_back(part);
      lines.weight.push_back(sums.samples);
    }
    scale(lines.value, gain, of_earth);
  }
}

/// Mean advance of the phase of a line from part to part [rad]; NaN where they are too few or do not agree.
double advance(const std::vector<Complex>& line) {
  if (line.size() < 4) return std::numeric_limits<double>::quiet_NaN();
  Complex turned = 0.0;
  double size = 0.0;
  for (std::size_t m = 1; m < line.size(); ++m) {
    turned += line[m] * std::conj(line[m - 1]);
    size += std::abs(line[m]) * std::abs(line[m - 1]);
  }
  return std::abs(turned) > 0.5 * size ? std::arg(turned) : std::numeric_limits<double>::quiet_NaN();
}

struct Rates {
  double arm, table;
  bool found = false;
};

/// How much faster theta and beta turn than assumed [rad/s], from the phases of the lines over the parts.
Rates rates_from_data(const Channels& channels, const Spin& stretch) {
  Rates rates{stretch.arm_rate, stretch.table_rate};
  const double part = (stretch.end - stretch.begin) / parts;
  for (int round = 0; round < 8; ++round) {
    const Angles angles(rates.arm, rates.table, 0.5 * (stretch.begin + stretch.end));
    std::vector<Complex> theta, beta;
    for (Group& group : groups_of(channels)) {
      if (std::ranges::find(group.signals, gyro) == group.signals.end()) continue;
      add_up(channels, stretch, angles, group);
      for (const Sums& sums : group.sums) {
        if (sums.samples < 4.0 * columns) continue;
        const Solver solver(gram_of(sums));
        if (!(solver.weakest > 1e-4)) continue;
        const Phasors one = phasors_of(solver.solve(moment_of(sums, 0)));
        theta.push_back(one.line[0]);
        beta.push_back(one.earth);
      }
    }
    double of_theta = advance(theta) / part, of_beta = advance(beta) / part;
    if (std::isnan(of_theta)) return rates;
    rates.found = true;
    if (std::isnan(of_beta)) of_beta = 0.0;
    rates.table -= of_theta;
    rates.arm += of_theta + of_beta;
    if ((std::abs(of_theta) + std::abs(of_beta)) * (stretch.end - stretch.begin) < 1e-6) break;
  }
  return rates;
}

/// Whether the signal stands still, or at one of its extremes for many samples together.
std::string fault_of(const Channel& channel, double begin, double end) {
  const std::size_t first = index_at(channel, begin), last = std::min(index_at(channel, end), channel.values.size());
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t i = first; i < last; ++i) {
    least = channel.values[i] < least ? channel.values[i] : least;
    most = channel.values[i] > most ? channel.values[i] : most;
  }
  if (least > most) return fmt::format("'{}' has no samples", channel.name);
  if (least == most) return fmt::format("'{}' stands still at one value", channel.name);
  std::size_t clipped = 0, run = 0;
  for (std::size_t i = first; i < last; ++i) {
    const double v = channel.values[i];
    const bool same = (v == least || v == most) && i > first && v == channel.values[i - 1];
    run = same ? run + 1 : 0;
    clipped += run == 2 ? 3 : run > 2 ? 1 : 0;
  }
  const double share = static_cast<double>(clipped) / static_cast<double>(last - first);
  if (share < 0.01) return "";
  const Unit& unit = channel.unit;
  return fmt::format("'{}' is clipped: {:.2g} % of its samples stand at {:.6g} or {:.6g} {}", channel.name,
                     100.0 * share, unit.from_si(least), unit.from_si(most), unit.text());
}

}  // namespace

Complex Channelling::gain(double rate, double step) const {
  const double half = 0.5 * rate * (averaging < 0.0 ? step : averaging);
  Complex gain = half == 0.0 ? 1.0 : std::sin(half) / half;
  const Complex s(0.0, rate);
  if (natural_frequency > 0.0) {
    const Complex r = s / natural_frequency;
    gain /= 1.0 + 2.0 * damping_ratio * r + r * r;
  } else if (time_constant > 0.0) {
    gain /= 1.0 + s * time_constant;
  }
  return gain * std::exp(-s * late);
}

Instruments instruments_of(const Settings& settings) {
  Instruments out;
  const auto number = [&](const std::string& name) { return settings.has(name) ? settings.number(name) : 0.0; };
  for (const Signal s : {gyro, gyro_y, reference}) {
    const std::string prefix = s == reference ? "reference_" : "";
    Channelling& one = out.of[s];
    one.averaging = settings.has(prefix + "averaging") ? settings.number(prefix + "averaging") : -1.0;
    one.natural_frequency = two_pi * number(prefix + "natural_frequency");
    one.damping_ratio = number(prefix + "damping_ratio");
    one.time_constant = number(prefix + "time_constant");
  }
  out.of[reference].late = number("reference_clock_offset");
  out.encoders_in_middle = settings.word("encoder_stamps") == "begin";
  return out;
}

Measured measure(const Test& test, const Spin& stretch, const Instruments& instruments) {
  const Channels& channels = test.channels[stretch.recording];
  Measured out;
  out.stretch = &stretch;
  for (const Signal s : {gyro, gyro_y, reference})
    if (channels.signal[s] != nullptr) out.of[s].fault = fault_of(*channels.signal[s], stretch.begin, stretch.end);
  for (const Signal s : {gyro, reference})
    if (!out.of[s].fault.empty()) out.fault += (out.fault.empty() ? "" : ", ") + out.of[s].fault;
  if (!out.fault.empty()) return out;
  Angles angles(stretch.arm_rate, stretch.table_rate, 0.5 * (stretch.begin + stretch.end));
  if (test.encoders) {
    angles = Angles(*channels.arm, *channels.table, instruments.encoders_in_middle, stretch.begin, stretch.end);
  } else {
    const Rates rates = rates_from_data(channels, stretch);
    angles = Angles(rates.arm, rates.table, 0.5 * (stretch.begin + stretch.end));
    out.rates_found = rates.found;
  }
  out.arm_rate = angles.arm_rate();
  out.table_rate = angles.table_rate();
  out.unsteady = angles.unsteady();
  if (!std::isfinite(out.arm_rate) || !std::isfinite(out.table_rate)) {
    out.fault = "too few readings of the angles";
    return out;
  }
  for (Group& group : groups_of(channels)) {
    add_up(channels, stretch, angles, group);
    solve(group, instruments, out, channels);
  }
  return out;
}

double mean_of(const Channel& channel, double begin, double end) {
  double sum = 0.0, count = 0.0;
  const std::size_t last = std::min(index_at(channel, end), channel.values.size());
  for (std::size_t i = index_at(channel, begin); i < last; ++i)
    if (!std::isnan(channel.values[i])) {
      sum += channel.values[i];
      count += 1.0;
    }
  return sum / count;
}

}  // namespace tumble::dtg_centrifuge
