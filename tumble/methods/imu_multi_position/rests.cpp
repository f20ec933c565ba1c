#include "tumble/methods/imu_multi_position/rests.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/median.hpp"
#include "tumble/methods/imu_multi_position/start.hpp"

namespace tumble::imu_multi_position {
namespace {

constexpr std::size_t least_window = 16, windows_of_record = 8;  ///< samples; windows that a record must have at least
constexpr double other_step = 1e-9;                            ///< [1] of the largest change: a smaller one is rounding
constexpr std::size_t quiet_of_rest = 2, quiet_of_record = 5;  ///< the level is exceeded by half, or by four in five
constexpr double least_level = 1e-12;                          ///< [1] of the greatest variance: for data without noise
constexpr std::size_t fewest_of_rest = 8;                      ///< samples
constexpr double longest_pause = 2.0, same_direction = 0.02;   ///< [s] and [rad] between two rests that are one: 1 deg
/// [sd of white noise], and [1] of the median of all, of a drift during a rest; noise by itself gives sqrt(3).
constexpr double drift_sd = 8.0, drift_beyond = 8.0;
/// [1] of the variance of the quietest fifth, below which it is at rest. Beyond the usual ones are those of a session in which a
/// hand held the unit in some rests and a table in others (the variance was 66 to 190 times that of the table): they are tried
/// where the others give too few rests.
constexpr double multipliers[] = {2.0, 3.0, 4.5, 7.0, 10.0, 15.0, 25.0, 40.0, 65.0, 100.0, 160.0, 250.0};
constexpr double greatest_usual = 40.0;
constexpr double block_of_rest = 0.25, samples_of_block = 8.0;  ///< [1] of the shortest rest; at least so many samples

struct Span {
  double begin, end;
};

/// Variance about each sample over a window, summed over the axes; infinite near missing samples, gaps and ends.
struct Quiet {
  std::vector<double> variance;
  double level = 0.0;  ///< of rest
};

std::size_t window_of(const Triad& triad, double seconds) {
  const auto n = static_cast<std::size_t>(std::llround(seconds / triad.step));
  return std::clamp<std::size_t>(n, least_window,
                                 std::max<std::size_t>(least_window, triad.value.size() / windows_of_record));
}

std::vector<double> window_variance(const Triad& triad, std::size_t window) {
  const std::size_t n = triad.value.size();
  Vector3 mean;  // keeps the sums of squares small
  double finite_samples = 0.0;
  for (const auto& v : triad.value)
    if (is_finite(v)) mean += v, finite_samples += 1.0;
  mean = mean / std::max(finite_samples, 1.0);
  std::vector<double> variance(n, std::numeric_limits<double>::infinity());
  std::vector<char> bad(n, 0);
  for (const std::size_t after : triad.gaps) bad[std::min(after + 1, n - 1)] = 1;
  Vector3 sum;
  double squares = 0.0;
  std::size_t unfit = 0;
  const auto put = [&](std::size_t i, double sign) {
    const bool finite = is_finite(triad.value[i]);
    if (!finite || bad[i]) unfit += sign > 0.0 ? 1 : -1;
    if (!finite) return;
    const Vector3 v = triad.value[i] - mean;
    sum += sign * v, squares += sign * dot(v, v);
  };
  const double w = static_cast<double>(window);
  for (std::size_t i = 0; i < n; ++i) {
    put(i, 1.0);
    if (i >= window) put(i - window, -1.0);
    if (i + 1 < window) continue;
    const double v = (squares - dot(sum, sum) / w) / (w - 1.0);
    if (unfit == 0) variance[i + 1 - window + window / 2] = std::max(v, 0.0);
  }
  return variance;
}

/// Least change of each output from sample to sample: a step of its resolution; 0: it never changes.
Vector3 steps_of(const Triad& triad) {
  Vector3 steps;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double step = std::numeric_limits<double>::infinity(), size = 0.0;
    for (std::size_t i = 1; i < triad.value.size(); ++i) {
      if (triad.filled[i] || triad.filled[i - 1]) continue;
      const double change = std::abs(triad.value[i][axis] - triad.value[i - 1][axis]);
      size = std::max(size, change);
      if (change > other_step * size && change < step) step = change;
    }
    if (std::isfinite(step)) steps[axis] = step;
  }
  return steps;
}

/// Variance of an output that changes between two neighbouring steps of its resolution: motion cannot be distinguished
/// from rest below it.
double variance_of_step(const Triad& triad) {
  const Vector3 steps = steps_of(triad);
  return 0.25 * dot(steps, steps);
}

Quiet quiet_of(const std::vector<Session>& sessions, std::size_t s, bool gyro, const RestOptions& options) {
  const Triad& triad = gyro ? sessions[s].gyro : sessions[s].accelerometer;
  const std::size_t window = window_of(triad, options.window);
  Quiet quiet{window_variance(triad, window), 0.0};
  std::vector<double> blocks;
  double scale = 0.0;
  const double until = options.initial_rest > 0.0 ? triad.time.front() + options.initial_rest : triad.time.back();
  for (std::size_t i = window / 2; i < quiet.variance.size() && triad.time[i] <= until; i += window)
    if (std::isfinite(quiet.variance[i])) blocks.push_back(quiet.variance[i]);
  for (const double v : quiet.variance)
    if (std::isfinite(v)) scale = std::max(scale, v);
  if (blocks.empty()) return quiet;
  const std::size_t fifth =
      options.initial_rest > 0.0 ? blocks.size() / quiet_of_rest : blocks.size() / quiet_of_record;
  std::nth_element(blocks.begin(), blocks.begin() + static_cast<long>(fifth), blocks.end());
  quiet.level = std::max({blocks[fifth], least_level * scale, variance_of_step(triad)});
  return quiet;
}

std::vector<Span> spans_of(const Triad& triad, const Quiet& quiet, double multiplier) {
  std::vector<Span> spans;
  const double bound = multiplier * quiet.level;
  bool resting = false;
  for (std::size_t i = 0; i < quiet.variance.size(); ++i) {
    const bool still = quiet.variance[i] <= bound;
    if (still && !resting) spans.push_back({triad.time[i], triad.time[i]});
    if (still) spans.back().end = triad.time[i];
    resting = still;
  }
  return spans;
}

std::vector<Span> both(const std::vector<Span>& a, const std::vector<Span>& b) {
  std::vector<Span> out;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    const Span s{std::max(a[i].begin, b[j].begin), std::min(a[i].end, b[j].end)};
    if (s.end > s.begin) out.push_back(s);
    (a[i].end < b[j].end ? i : j) += 1;
  }
  return out;
}

Vector3 mean_of(const Triad& triad, double begin, double end, std::size_t& samples) {
  Vector3 sum;
  const std::size_t first = triad.index(begin), last = triad.index(end);
  for (std::size_t i = first; i < last; ++i) sum += triad.value[i];
  samples = last - first;
  return sum / static_cast<double>(std::max<std::size_t>(samples, 1));
}

using Quiets = std::vector<std::array<Quiet, 2>>;

std::vector<Rest> rests_at(const std::vector<Session>& sessions, const Quiets& quiets, double multiplier,
                           const RestOptions& options) {
  std::vector<Rest> rests;
  for (std::size_t s = 0; s < sessions.size(); ++s) {
    const Session& session = sessions[s];
    auto spans = spans_of(session.accelerometer, quiets[s][0], multiplier);
    if (!session.gyro.empty()) spans = both(spans, spans_of(session.gyro, quiets[s][1], multiplier));
    for (const Span& span : spans) {
      if (span.end - span.begin < options.least) continue;
      Rest rest{.session = s, .begin = span.begin, .end = span.end};
      rest.force = mean_of(session.accelerometer, span.begin, span.end, rest.samples);
      if (!session.gyro.empty()) rest.rate = mean_of(session.gyro, span.begin, span.end, rest.gyro_samples);
      if (rest.samples >= fewest_of_rest) rests.push_back(std::move(rest));
    }
  }
  return rests;
}

bool same_pose(const Rest& a, const Rest& b, const Linear& of) {
  if (a.session != b.session || b.begin - a.end > longest_pause) return false;
  const Inverse felt(of);
  return norm(normalised(felt(a.force)) - normalised(felt(b.force))) < same_direction;  // nobody intends a smaller turn
}

void reject_parts(std::vector<Rest>& rests, const Linear& of) {
  std::size_t longest = 0;  // of the present pose
  for (std::size_t k = 1; k < rests.size(); ++k) {
    if (!same_pose(rests[longest], rests[k], of)) {
      longest = k;
      continue;
    }
    const bool longer = rests[k].end - rests[k].begin > rests[longest].end - rests[longest].begin;
    rests[longer ? longest : k].rejection = Finding(Finding::Severity::warning, "rest_interrupted", {});
    if (longer) longest = k;
  }
}

void reject_drifting(const std::vector<Session>& sessions, const Densities& noise, std::vector<Rest>& rests) {
  constexpr double of_two_halves = 1.0 / 6.0;  // [steps^2] of the difference of two means that rounding moves
  std::vector<Vector3> steps;
  for (const Session& session : sessions) steps.push_back(steps_of(session.accelerometer));
  std::vector<double> sizes;
  for (const Rest& rest : rests) {
    Vector3 drift = drift_of(sessions[rest.session].accelerometer, rest);
    for (std::size_t i = 0; i < 3; ++i) {
      const double rounding = of_two_halves * std::pow(steps[rest.session][i], 2);
      drift[i] /= std::max(std::sqrt(4.0 * noise.force[i] / (rest.end - rest.begin) + rounding), 1e-300);
    }
    sizes.push_back(norm(drift));
  }
  const double bound = std::max(drift_sd, drift_beyond * median(sizes));
  for (std::size_t k = 0; k < rests.size(); ++k)
    if (rests[k].used() && sizes[k] > bound)
      rests[k].rejection = Finding(Finding::Severity::warning, "rest_drifts", {});
}

/// Sums of squares of block means about the mean of their rest.
void add_blocks(const Triad& triad, const Rest& rest, double block, Vector3& squares, double& degrees) {
  const double length = rest.end - rest.begin;
  const auto blocks = static_cast<std::size_t>(std::floor(length / block));
  if (blocks < 2) return;
  std::size_t n = 0;
  std::vector<Vector3> means;
  Vector3 mean;
  for (std::size_t b = 0; b < blocks; ++b) {
    const double begin = rest.begin + static_cast<double>(b) * block;
    means.push_back(mean_of(triad, begin, begin + block, n));
    mean += means.back() / static_cast<double>(blocks);
  }
  for (const auto& m : means) squares += scaled(m - mean, m - mean);
  degrees += static_cast<double>(blocks - 1);
}

/// A quarter of the shortest rest, and not a few samples.
double block_of(const std::vector<Session>& sessions, const RestOptions& options) {
  double step = sessions[0].accelerometer.step;
  for (const auto& session : sessions)
    step = std::max({step, session.accelerometer.step, session.gyro.empty() ? 0.0 : session.gyro.step});
  return std::max(block_of_rest * options.least, samples_of_block * step);
}

Densities densities_of(const std::vector<Session>& sessions, const std::vector<Rest>& rests,
                       const RestOptions& options) {
  Densities out;
  const double block = block_of(sessions, options);
  double gyro_degrees = 0.0;
  for (const Rest& rest : rests) {
    if (!rest.used()) continue;
    const Session& session = sessions[rest.session];
    add_blocks(session.accelerometer, rest, block, out.force, out.degrees_of_freedom);
    if (!session.gyro.empty()) add_blocks(session.gyro, rest, block, out.rate, gyro_degrees);
  }
  out.force *= block / std::max(out.degrees_of_freedom, 1.0);
  out.rate *= block / std::max(gyro_degrees, 1.0);
  return out;
}

}  // namespace

Vector3 drift_of(const Triad& triad, const Rest& rest) {
  const double middle = 0.5 * (rest.begin + rest.end);
  std::size_t n = 0;
  return mean_of(triad, middle, rest.end, n) - mean_of(triad, rest.begin, middle, n);
}

Rests find_rests(const std::vector<Session>& sessions, const RestOptions& options, double gravity) {
  Quiets quiets(sessions.size());
  for (std::size_t s = 0; s < sessions.size(); ++s) {
    quiets[s][0] = quiet_of(sessions, s, false, options);
    if (!sessions[s].gyro.empty()) quiets[s][1] = quiet_of(sessions, s, true, options);
  }
  Rests best;
  double least = std::numeric_limits<double>::infinity();
  Linear start;
  for (const double multiplier : multipliers) {
    if (multiplier > greatest_usual && std::isfinite(least)) break;
    auto rests = rests_at(sessions, quiets, multiplier, options);
    std::vector<Vector3> means;
    for (const Rest& rest : rests) means.push_back(rest.force);
    const auto sphere = fit_sphere(means, gravity);
    if (sphere) ++best.tried;
    const bool better = sphere ? sphere->log_determinant < least
                               : least == std::numeric_limits<double>::infinity() && rests.size() > best.all.size();
    if (!better) continue;
    if (sphere) least = sphere->log_determinant, start = sphere->accelerometer;
    best.all = std::move(rests), best.multiplier = multiplier;
  }
  if (least == std::numeric_limits<double>::infinity()) return best;
  reject_parts(best.all, start);
  best.noise = densities_of(sessions, best.all, options);
  reject_drifting(sessions, best.noise, best.all);
  best.noise = densities_of(sessions, best.all, options);
  return best;
}

}  // namespace tumble::imu_multi_position
