#include "tumble/methods/rlg_north_finder/closed_form.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/matrix3.hpp"
#include "tumble/methods/rlg_north_finder/solve.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rlg_north_finder {
namespace {

constexpr double upright_cosine = 0.9;  ///< cosine of the angle of an axis to the vertical: 26 deg
constexpr double most_beside = 0.5;     ///< [1] of the specific force beside that of the upright axis: none is upright

double mean_of(const std::vector<double>& values, const std::vector<std::size_t>& which) {
  double sum = 0.0;
  for (const std::size_t s : which) sum += values[s];
  return sum / static_cast<double>(which.size());
}

/// Counts of a rotation, as the total of its segment.
double total(const Turning& turning, const std::vector<double>& means) {
  return means[turning.segment] * turning.seconds;
}

/// What the gyro feels in a rotation forward less in reverse, along the axes of the body [rad]: along the axis of the
/// rotation whole turns and what a hand made of them, along the others what an axis that stands askew makes.
Vector3 turned(const Path& path, int axis, std::span<const linear::SegmentSummary> segments) {
  const Turning &forward = *path.rotation(axis, true), &reverse = *path.rotation(axis, false);
  Vector3 angle =
      forward.seconds * segments[forward.segment].felt.rate - reverse.seconds * segments[reverse.segment].felt.rate;
  angle[static_cast<std::size_t>(axis)] =
      two_pi * (std::round(forward.turns) - std::round(reverse.turns)) + forward.beyond - reverse.beyond;
  return angle;
}

/// K, K gamma_y, K gamma_z of N+ - N- = K (W_x + gamma_y W_y + gamma_z W_z) about x, y and z: (N+ - N-)/(2 Theta) each,
/// where every turn is about its axis alone.
Vector3 by_rotations(const Path& path, std::span<const linear::SegmentSummary> segments,
                     const std::vector<double>& means) {
  Matrix3 angles;
  Vector3 counts;
  for (int axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<std::size_t>(axis);
    angles[row] = turned(path, axis, segments);
    counts[row] = total(*path.rotation(axis, true), means) - total(*path.rotation(axis, false), means);
  }
  return inverse(angles) * counts;
}

/// Scale factor, bias and misalignments of an accelerometer: `own` its axis, `other` the other one that stands upright.
void append_accelerometer(const Path& path, const std::vector<double>& means, std::size_t own, std::size_t other,
                          double gravity, std::vector<double>& out) {
  const auto up = [&](std::size_t axis) { return mean_of(means, path.up[axis]); };
  const auto down = [&](std::size_t axis) { return mean_of(means, path.down[axis]); };
  const double k = (up(own) - down(own)) / (2.0 * gravity);
  const double z_up = means[path.up[2].back()], z_down = means[path.down[2].front()];
  out.push_back(k);
  out.push_back((up(own) + down(own) + up(other) + down(other)) / (4.0 * k));
  out.push_back((up(other) - down(other)) / (2.0 * k * gravity));
  out.push_back((z_up - z_down) / (2.0 * k * gravity));
}

/// The four stays that give the bias.
std::vector<std::size_t> four(const Path& path) {
  std::vector<std::size_t> all;
  for (const std::size_t axis : {0, 1})
    for (const auto* some : {&path.up[axis], &path.down[axis]}) all.push_back(some->front());
  return all;
}

}  // namespace

Means measured(const Summaries& segments) {
  Means means;
  for (std::size_t i = 0; i < outputs; ++i)
    for (const auto& segment : segments[i]) means[i].push_back(segment.measured);
  return means;
}

namespace {

/// Means of the accelerometers as if the axis that is nearly upright stood exactly so, by the angles and these
/// parameters.
Means as_if_upright(Means means, const Summaries& segments, const std::vector<double>& b) {
  for (const Which output : {accelerometer_x, accelerometer_y}) {
    const double* of = b.data() + output * per_output;  // scale factor, bias, misalignments toward the others
    for (std::size_t s = 0; s < means[output].size(); ++s) {
      const Vector3 force = segments[output][s].felt.specific_force;
      Vector3 beside = force;
      for (std::size_t i = 0; i < 3; ++i)
        if (std::abs(force[i]) > upright_cosine * norm(force)) beside[i] -= std::copysign(norm(force), force[i]);
      if (norm(beside) > most_beside * norm(force)) continue;  // no axis is upright
      const double own = output == accelerometer_x ? beside.x : beside.y;
      const double other = output == accelerometer_x ? beside.y : beside.x;
      means[output][s] -= of[0] * (own + of[2] * other + of[3] * beside.z);
    }
  }
  return means;
}

std::vector<double> of_upright(const Means& means, const Summaries& segments, double gravity) {
  std::array<Path, outputs> paths;
  for (std::size_t i = 0; i < outputs; ++i) paths[i] = path_of({segments[i].begin(), segments[i].end()});
  const Path& path = paths[gyro];
  const Vector3 by_axis = by_rotations(path, segments[gyro], means[gyro]);
  const double k = by_axis.x, gamma_y = by_axis.y / k, gamma_z = by_axis.z / k;
  double bias = 0.0;
  for (const std::size_t s : four(path)) {
    const Vector3 w = segments[gyro][s].felt.rate;
    bias += 0.25 * (means[gyro][s] / k - w.x - gamma_y * w.y - gamma_z * w.z);
  }
  std::vector<double> out{k, bias, gamma_y, gamma_z};
  append_accelerometer(paths[accelerometer_x], means[accelerometer_x], 0, 1, gravity, out);
  append_accelerometer(paths[accelerometer_y], means[accelerometer_y], 1, 0, gravity, out);
  return out;
}

}  // namespace

std::vector<double> closed_form(const Means& means, const Summaries& segments, double gravity) {
  constexpr int passes = 3;  // each takes 1 deg beside upright a factor of 50 further
  std::vector<double> b = of_upright(means, segments, gravity);
  for (int pass = 0; pass < passes; ++pass) b = of_upright(as_if_upright(means, segments, b), segments, gravity);
  return b;
}

Tilts tilts_of(const Means& as_measured, const Summaries& segments, const std::vector<double>& b, double gravity,
               double drift, const Settings& rig) {
  const Means means = as_if_upright(as_measured, segments, b);
  const auto stated = [&](const char* name) {
    return rig.texts().contains(name) && !rig.flag("ideal") ? rig.number(name) : 0.0;
  };
  Tilts tilts;
  const Path x = path_of({segments[accelerometer_x].begin(), segments[accelerometer_x].end()});
  const Path y = path_of({segments[accelerometer_y].begin(), segments[accelerometer_y].end()});
  if (x.up[2].empty() || x.down[2].size() < 2 || y.up[2].empty() || y.down[2].size() < 2) return tilts;
  const auto f_x = [&](std::size_t s) { return means[accelerometer_x][s] / b[4] - b[5]; };
  const auto f_y = [&](std::size_t s) { return means[accelerometer_y][s] / b[8] - b[9]; };
  tilts.known = true;
  tilts.rho_x = (f_y(y.up[2].back()) + f_y(y.down[2].front())) / (2.0 * gravity);
  const double s = (f_y(y.down[2].front()) - f_y(y.down[2].back())) / gravity;
  const double d = (f_x(x.down[2].back()) - f_x(x.down[2].front())) / gravity;
  tilts.rho_y = 0.5 * (s - d);
  tilts.eta = tilts.rho_x - 0.5 * (s + d);
  // errors of single positions; two of them or more enter each tilt with one half
  double squares = std::pow(stated("repeatability_sd"), 2) + std::pow(stated("wobble_once_sd"), 2) +
                   std::pow(stated("wobble_twice_sd"), 2);
  squares += std::pow(drift / gravity, 2);
  tilts.sd = std::sqrt(squares);
  return tilts;
}

namespace {

/// Where the means of an output begin among those of all.
std::array<std::size_t, outputs + 1> offsets(const std::vector<linear::Work>& works) {
  std::array<std::size_t, outputs + 1> begin{};
  for (std::size_t i = 0; i < outputs; ++i) begin[i + 1] = begin[i] + works[i].solution.segments.size();
  return begin;
}

/// Derivatives of the parameters by the means, as differences.
Matrix derivatives(const Means& means, const Summaries& segments, double gravity) {
  std::size_t all = 0;
  for (const auto& some : means) all += some.size();
  Matrix jacobian(outputs * per_output, all);
  std::size_t column = 0;
  for (std::size_t i = 0; i < outputs; ++i) {
    double size = 0.0;
    for (const double mean : means[i]) size = std::max(size, std::abs(mean));
    for (std::size_t s = 0; s < means[i].size(); ++s, ++column) {
      Means more = means, less = means;
      const double step = 1e-5 * size;
      more[i][s] += step;
      less[i][s] -= step;
      const auto a = closed_form(more, segments, gravity), b = closed_form(less, segments, gravity);
      for (std::size_t p = 0; p < a.size(); ++p) jacobian(p, column) = (a[p] - b[p]) / (2.0 * step);
    }
  }
  return jacobian;
}

/// Mean of a column over the rows of every segment.
std::vector<double> by_segment(const linear::Work& work, const std::vector<double>& column) {
  std::vector<double> sums(work.solution.segments.size(), 0.0), weights(sums.size(), 0.0);
  for (std::size_t i = 0; i < column.size(); ++i) {
    sums[work.rows.segment[i]] += work.rows.weights[i] * column[i];
    weights[work.rows.segment[i]] += work.rows.weights[i];
  }
  for (std::size_t g = 0; g < sums.size(); ++g) sums[g] /= weights[g];
  return sums;
}

class Sources {
 public:
  Matrix& operator[](const std::string& name) {
    for (auto& line : list)
      if (line.source == name) return line.covariance;
    list.push_back({name, Matrix(outputs * per_output, outputs * per_output)});
    return list.back().covariance;
  }
  std::vector<SourceCovariance> list;
};

/// Noise and drift of one output.
void add_noise(const linear::Work& work, std::size_t first, const Matrix& jacobian, Sources& sources) {
  const auto& segments = work.solution.segments;
  const Matrix of_means = block(jacobian, 0, jacobian.rows, first, segments.size());
  std::vector<double> variances;
  for (const auto& segment : segments) variances.push_back(segment.sd * segment.sd);
  sources[work.data.white] += sandwich(of_means, variances);
  for (std::size_t c = 0; c < work.data.slow.size(); ++c)
    sources[work.data.slow[c].source] +=
        work.solution.fit.slow_variance[c] * sandwich(of_means, work.data.slow[c].kernel);
}

/// Lines of the errors of the table, by draw: one moves all outputs.
void add_effects(const std::vector<linear::Work>& works, const Matrix& jacobian, std::vector<ErrorLine>& lines) {
  struct Shift {
    std::vector<double> means;
    std::string key;
  };
  const auto first = offsets(works);
  std::map<std::pair<std::string, std::string>, Shift> shifts;
  for (std::size_t i = 0; i < outputs; ++i)
    for (std::size_t e = 0; e < works[i].data.effects.size(); ++e) {
      const KnownEffect& effect = works[i].data.effects[e];
      const auto means = by_segment(works[i], effect.column);
      for (std::size_t g = 0; g < means.size(); ++g) {
        std::string draw = std::to_string(i) + " " + std::to_string(e);  // its own
        if (effect.each_segment) draw += " " + std::to_string(g);
        if (!effect.draws.empty()) draw = effect.draws[effect.each_segment ? g : 0];
        auto& shift = shifts[{effect.source, draw}];
        shift.means.resize(jacobian.columns);
        shift.means[first[i] + g] += means[g];
        shift.key = effect.key;
      }
    }
  for (const auto& [draw, shift] : shifts)
    lines.push_back(from_shifts(draw.first, as_column(jacobian * shift.means), shift.key));
}

}  // namespace

Estimate closed_form_estimate(const std::vector<linear::Work>& works, double gravity) {
  Summaries segments;
  for (std::size_t i = 0; i < outputs; ++i) segments[i] = works[i].solution.segments;
  const Means means = measured(segments);
  const Matrix jacobian = derivatives(means, segments, gravity);
  const auto first = offsets(works);
  Sources sources;
  for (std::size_t i = 0; i < outputs; ++i) add_noise(works[i], first[i], jacobian, sources);
  auto lines = lines_of(sources.list);
  add_effects(works, jacobian, lines);
  std::vector<double> freedom;
  for (std::size_t i = 0; i < outputs; ++i)
    for (std::size_t k = 0; k < per_output; ++k) freedom.push_back(freedom_of(works[i].solution.fit, k));
  Estimate estimate = estimate_from(closed_form(means, segments, gravity), freedom, lines);
  for (const auto& work : works) {
    estimate.fit.observations += work.solution.segments.size();
    estimate.fit.chi_square += work.solution.fit.chi_square;
    estimate.fit.condition = std::max(estimate.fit.condition, work.solution.fit.condition);
  }
  estimate.fit.degrees_of_freedom = static_cast<double>(estimate.fit.observations - outputs * per_output);
  return estimate;
}

}  // namespace tumble::rlg_north_finder
