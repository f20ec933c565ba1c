#include "tumble/methods/dtg_centrifuge/lines.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/dtg_centrifuge/angles.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Columns = std::vector<double>;

/// [1] of the information of a line, that a part may lose to the others: a factor for more is no longer an estimate.
constexpr double most_information_lost = 0.9;
constexpr double samples_of_column = 4.0;  ///< that are wanted for each column, so that noise has degrees of freedom
/// Least eigenvalue of the columns of unit length, by which all lines of a stretch, and of one of its parts, differ.
constexpr double weakest_of_stretch = 1e-6, weakest_of_part = 1e-4;
constexpr double suppressed_gain = 0.1;  ///< [1] of a line: its noise is then ten times that of the output
constexpr int rounds_of_rates = 8;
constexpr double angle_settled = 1e-6;  ///< [rad] of the whole stretch, by which the rates change in the last round
/// [1] of the time that a crest takes in a coarse output: half more, where the output ends a step below it.
constexpr double crest_share = 1.5;
/// [1] of the samples at the extremes. Chosen: less moves a line by less than 1e-3.
constexpr double clipped_share = 0.01;

constexpr std::size_t parts = 16;
constexpr std::size_t chunk = 4096;

Matrix gram_of(const Sums& sums) {
  Matrix gram(columns, columns);
  std::size_t k = 0;
  for (std::size_t i = 0; i < columns; ++i)
    for (std::size_t j = i; j < columns; ++j) gram(i, j) = gram(j, i) = sums.gram[k++];
  return gram;
}

Columns moment_of(const Sums& sums, std::size_t signal) {
  return {sums.moment[signal].begin(), sums.moment[signal].end()};
}

/// The phasors of one fit: coefficients of cosine and sine, Z = cosine - i sine.
Phasors phasors_of(const Columns& b) {
  return {{Complex(b[2], -b[3]), Complex(b[4], -b[5]), Complex(b[6], -b[7])}, Complex(b[8], -b[9])};
}

/// Normal equations, scaled to a unit diagonal.
struct Solver {
  Columns scale;
  Cholesky root;
  double weakest = 0.0;  ///< least eigenvalue; the equations are solved where it is above 0

  explicit Solver(const Matrix& gram) {
    for (const double square : diagonal_of(gram)) scale.push_back(square > 0.0 ? 1.0 / std::sqrt(square) : 0.0);
    const Matrix correlation = scaled_rows(scale, scaled_columns(gram, scale));
    weakest = eigenvalues_symmetric(correlation)[0];
    root = cholesky(correlation);
  }
  Columns solve(const Columns& moment) const { return scaled(scale, tumble::solve(root, scaled(scale, moment))); }
  Matrix solve(const Matrix& moments) const {
    return scaled_rows(scale, tumble::solve(root, scaled_rows(scale, moments)));
  }
};

/// The signals that are recorded on one clock, and their sums over each part of the stretch.
struct OneClock {
  std::vector<Signal> signals;
  std::array<Sums, parts> sums;
  double expected = 0.0;  ///< samples
};

void add_up(const Channels& channels, const Spin& stretch, const Angles& angles, OneClock& group) {
  const Channel& clock = *channels.signal[group.signals.front()];
  const double step = channels.step[group.signals.front()], length = stretch.end - stretch.begin,
               slack = stamp_slack(stretch.end, step);
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
      angles.at(clock, step, at, block.samples, work, block.arm, block.table);
      for (std::size_t s = 0; s < block.signals; ++s)
        block.signal[s] = channels.signal[group.signals[s]]->values.data() + at;
      block.tau = 2.0 * (clock.time(at) - stretch.begin) / length - 1.0;
      block.tau_step = 2.0 * step / length;
      add_to(group.sums[k], block);
    }
  }
  group.expected = std::floor(length / step + 1e-3);
}

std::vector<OneClock> groups_of(const Channels& channels) {
  std::vector<OneClock> groups;
  for (const Signal s : {gyro, reference, gyro_y}) {
    const Channel* channel = channels.signal[s];
    if (channel == nullptr) continue;
    const auto group = std::ranges::find_if(
        groups, [&](const OneClock& g) { return one_clock(*channels.signal[g.signals.front()], *channel); });
    (group == groups.end() ? *groups.insert(groups.end(), OneClock{}) : *group).signals.push_back(s);
  }
  return groups;
}

/// Responses of the electronics to the lines at the rates of a level.
Phasors gains_of(const Channelling& electronics, const Measured& measured, double step) {
  Phasors gain;
  for (std::size_t h = 0; h < 3; ++h)
    gain.line[h] = electronics.gain(static_cast<double>(h + 1) * measured.theta_rate(), step);
  gain.earth = electronics.gain(measured.beta_rate(), step);
  return gain;
}

Phasors operator/(Phasors p, const Phasors& gain) {
  for (std::size_t h = 0; h < 3; ++h) p.line[h] /= gain.line[h];
  p.earth /= gain.earth;
  return p;
}

/// The fit follows the parts, so that they scatter less about it than their noise: of the variance of column j a share
/// h_j = [N^-1 SUM N_m N^-1 N_m N^-1]_jj/[N^-1]_jj is lost, 1/M where all parts are alike, more where they hold less
/// than a period. Factor that makes the lost share 1/M, for cosine and sine of a line together.
Columns inflation_of(const OneClock& group, const Solver& solver) {
  Matrix lost(columns, columns);
  double used = 0.0;
  for (const Sums& sums : group.sums) {
    if (!(sums.samples > 0.0)) continue;
    const Matrix of_part = gram_of(sums);
    lost += of_part * solver.solve(of_part);
    used += 1.0;
  }
  const Matrix inverse = solver.solve(identity(columns)), of_inverse = solver.solve(transposed(solver.solve(lost)));
  Columns factor(columns, 1.0);
  for (std::size_t j = 2; j + 1 < columns; j += 2) {
    const double h = (of_inverse(j, j) + of_inverse(j + 1, j + 1)) / (inverse(j, j) + inverse(j + 1, j + 1));
    if (used > 1.0 && h < most_information_lost) factor[j] = factor[j + 1] = std::sqrt((1.0 - 1.0 / used) / (1.0 - h));
  }
  return factor;
}

/// Lines of one signal of a group: those of all parts, and b_m = b + (n/n_m) N^-1 (g_m - N_m b) of each.
void solve_signal(const OneClock& group, std::size_t k, const Sums& all, const Solver& solver, const Columns& inflation,
                  const Phasors& gain, Lines& lines) {
  const Columns moment = moment_of(all, k), b = solver.solve(moment);
  lines.present = true;
  lines.value = phasors_of(b) / gain;
  lines.mean = b[0];
  lines.samples = all.samples;
  lines.lost = std::max(0.0, group.expected - all.samples);
  lines.residual_sd = std::sqrt(std::max(0.0, all.square[k] - dot(b, moment)) / (all.samples - columns));
  for (const Sums& sums : group.sums) {
    Phasors part;
    if (sums.samples > 0.0) {
      const Columns extra = solver.solve(difference(moment_of(sums, k), gram_of(sums) * b));
      part = phasors_of(scaled_sum(b, all.samples / sums.samples, scaled(inflation, extra))) / gain;
    }
    lines.part.push_back(part);
    lines.weight.push_back(sums.samples);
  }
}

/// Least squares over all parts, for the signals of a group.
void solve(const OneClock& group, const Instruments& instruments, Measured& measured, const Channels& channels) {
  Sums all;
  for (const Sums& sums : group.sums) all += sums;
  const bool enough = all.samples > samples_of_column * columns;
  const Solver solver(gram_of(all));
  if (!enough || !(solver.weakest > weakest_of_stretch)) {
    measured.weakest = 0.0;
    return;
  }
  measured.weakest = std::min(measured.weakest, solver.weakest);
  const Columns inflation = inflation_of(group, solver);
  for (std::size_t k = 0; k < group.signals.size(); ++k) {
    const Signal signal = group.signals[k];
    Lines& lines = measured.of[signal];
    lines.step = channels.step[signal];
    const Phasors gain = gains_of(instruments.of[signal], measured, lines.step);
    if (std::abs(gain.line[0]) < suppressed_gain && measured.faults.empty())
      measured.faults.push_back({Finding::Severity::error, "line_suppressed", {}, where_of(*measured.stretch)});
    solve_signal(group, k, all, solver, inflation, gain, lines);
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
  bool visible = false;  ///< a line shows them
};

/// How much faster theta and beta turn than assumed [rad/s], from the phases of the lines over the parts.
Rates rates_from_data(const Channels& channels, const Spin& stretch) {
  Rates rates{stretch.arm_rate, stretch.table_rate};
  const double part = (stretch.end - stretch.begin) / parts;
  for (int round = 0; round < rounds_of_rates; ++round) {
    const Angles angles(rates.arm, rates.table, 0.5 * (stretch.begin + stretch.end));
    std::vector<Complex> theta, beta;
    for (OneClock& group : groups_of(channels)) {
      if (std::ranges::find(group.signals, gyro) == group.signals.end()) continue;
      add_up(channels, stretch, angles, group);
      for (const Sums& sums : group.sums) {
        if (sums.samples < samples_of_column * columns) continue;
        const Solver solver(gram_of(sums));
        if (!(solver.weakest > weakest_of_part)) continue;
        const Phasors part_lines = phasors_of(solver.solve(moment_of(sums, 0)));
        theta.push_back(part_lines.line[0]);
        beta.push_back(part_lines.earth);
      }
    }
    double of_theta = advance(theta) / part, of_beta = advance(beta) / part;
    if (std::isnan(of_theta)) return rates;
    rates.visible = true;
    if (std::isnan(of_beta)) of_beta = 0.0;
    rates.table -= of_theta;
    rates.arm += of_theta + of_beta;
    if ((std::abs(of_theta) + std::abs(of_beta)) * (stretch.end - stretch.begin) < angle_settled) break;
  }
  return rates;
}

/// Share of the samples that stay at one end of a signal's values for three samples or more; none where the crest of a
/// line of this amplitude stays so long in the last step of a coarse output: arccos(1 - q/A)/pi of the time, by half
/// more if the output ends a step below the crest.
double share_at(const Channel& channel, std::size_t first, std::size_t last, double end, double other) {
  std::size_t count = 0, run = 0;
  double next = other;
  for (std::size_t i = first; i < last; ++i) {
    const double v = channel.values[i];
    if (v != end && std::abs(v - end) < std::abs(next - end)) next = v;
    run = v == end && i > first && v == channel.values[i - 1] ? run + 1 : 0;
    count += run == 2 ? 3 : run > 2 ? 1 : 0;
  }
  const double share = static_cast<double>(count) / static_cast<double>(last - first);
  const double amplitude = 0.5 * std::abs(end - other), step = std::abs(next - end);
  const double crest = std::acos(std::max(-1.0, 1.0 - step / amplitude)) / pi;
  return share > crest_share * crest ? share : 0.0;
}

/// Findings where the signal is constant, or at one of its extremes for many samples together.
Findings faults_of(const Channel& channel, const Spin& spin) {
  using Severity = Finding::Severity;
  const std::size_t first = index_at(channel, spin.begin),
                    last = std::min(index_at(channel, spin.end), channel.values.size());
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t i = first; i < last; ++i) {
    least = channel.values[i] < least ? channel.values[i] : least;
    most = channel.values[i] > most ? channel.values[i] : most;
  }
  if (least > most) return {{Severity::error, "channel_without_samples", {{"channel", channel.name}}, where_of(spin)}};
  if (least == most) return {{Severity::error, "channel_constant", {{"channel", channel.name}}, where_of(spin)}};
  const double share = share_at(channel, first, last, least, most) + share_at(channel, first, last, most, least);
  if (share < clipped_share) return {};
  return {
      {Severity::error,
       "channel_clipped",
       {{"channel", channel.name}, {"share", share, "%"}, {"least", least, channel.unit}, {"most", most, channel.unit}},
       where_of(spin)}};
}

/// The encoder that stays where it is although the plan turns its axis; null: none.
const Channel* encoder_at_rest(const Measured& measured, const Channels& channels) {
  constexpr double at_rest = 1e-3;  // [1] of the planned rate
  const Spin& spin = *measured.stretch;
  if (channels.arm != nullptr && std::abs(measured.arm_rate) < at_rest * std::abs(spin.arm_rate)) return channels.arm;
  if (channels.table != nullptr && std::abs(measured.table_rate) < at_rest * std::abs(spin.table_rate))
    return channels.table;
  return nullptr;
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
    Channelling& electronics = out.of[s];
    electronics.averaging = settings.has(prefix + "averaging") ? settings.number(prefix + "averaging") : -1.0;
    electronics.natural_frequency = two_pi * number(prefix + "natural_frequency");
    electronics.damping_ratio = number(prefix + "damping_ratio");
    electronics.time_constant = number(prefix + "time_constant");
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
    if (channels.signal[s] != nullptr) out.of[s].faults = faults_of(*channels.signal[s], stretch);
  for (const Signal s : {gyro, reference})
    out.faults.insert(out.faults.end(), out.of[s].faults.begin(), out.of[s].faults.end());
  if (!out.faults.empty()) return out;
  Angles angles(stretch.arm_rate, stretch.table_rate, 0.5 * (stretch.begin + stretch.end));
  if (test.encoders) {
    angles = Angles(channels, instruments.encoders_in_middle, stretch.begin, stretch.end);
  } else {
    const Rates rates = rates_from_data(channels, stretch);
    angles = Angles(rates.arm, rates.table, 0.5 * (stretch.begin + stretch.end));
    out.rates_visible = rates.visible;
  }
  out.arm_rate = angles.arm_rate();
  out.table_rate = angles.table_rate();
  out.unsteady = angles.unsteady();
  if (const Channel* still = encoder_at_rest(out, channels)) {
    out.faults.push_back({Finding::Severity::error, "channel_constant", {{"channel", still->name}}, where_of(stretch)});
    return out;
  }
  if (!std::isfinite(out.arm_rate) || !std::isfinite(out.table_rate)) {
    out.faults.push_back({Finding::Severity::error, "too_few_angles", {}, where_of(stretch)});
    return out;
  }
  for (OneClock& group : groups_of(channels)) {
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
