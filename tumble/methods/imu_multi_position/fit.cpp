#include "tumble/methods/imu_multi_position/fit.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/methods/imu_multi_position/faults.hpp"

namespace tumble::imu_multi_position {
namespace {

using Basis = std::array<Vector3, 2>;

constexpr double least_vertical_sd = 1e-3;  ///< [Earth's rate] below it the known part would only burden the solution
constexpr double least_path = 1e-4;         ///< [rad^2] of a move, for its errors that grow with its path
constexpr int passes_of_bias = 5;           ///< with weights that make the sum of lengths smallest
constexpr double start_of_turns = 1e-4;     ///< [1] first value of the variance that grows with the path
constexpr std::size_t fewest_of_part = 8, most_rejected = 4;  ///< groups of a part; one in so many may be rejected
constexpr double near_farthest = 0.6;    ///< [1] of the farthest: nearer ones may be far because of it, and wait a pass
constexpr double least_distance = 1e-3;  ///< [sd] of the median, against data without noise
constexpr int first_iterations = 8, most_passes = 10, iterations_of_pass = 3, last_iterations = 6;

/// Two directions across n.
Basis across(Vector3 n) {
  const Vector3 size = absolute(n);
  const std::size_t least = size.x <= size.y && size.x <= size.z ? 0 : size.y <= size.z ? 1 : 2;
  const Vector3 first = normalised(cross(n, identity3()[least]));
  return {first, cross(n, first)};
}

void put_chain(const Basis& basis, Vector3 v, Row& row) {
  row.chain[0] = dot(basis[0], v), row.chain[1] = dot(basis[1], v);
}

struct Work {
  const std::vector<Session>& sessions;
  Rests& rests;
  const FitOptions& options;
  Fit& fit;
};

constexpr double floor_of_noise = 1e-10;  ///< relative; for data without any

/// Puts a row of a block [3 columns] of derivatives into an observation.
void put(Vector3 block, std::size_t from, Row& row) {
  for (std::size_t j = 0; j < 3; ++j) row.common[from + j] = block[j];
}

void set_rest(const Work& work, Group& group) {
  const Fit& fit = work.fit;
  const Rest& rest = work.rests.all[group.index];
  const Linear& linear = fit.calibration.accelerometer;
  const Vector3 n = fit.direction[group.pair], force = work.options.gravity * n;
  const Vector3 residual = rest.force - linear.matrix * force - linear.bias;
  const Basis basis = across(n);
  group.columns = of_accelerometers;
  group.rows.assign(3, {});
  for (std::size_t i = 0; i < 3; ++i) {
    Row& row = group.rows[i];
    row.residual = residual[i];
    std::ranges::copy(derivative(identity3()[i], force), row.common.begin());
    put_chain(basis, work.options.gravity * linear.matrix[i], row);
    row.unit = std::pow(linear.matrix(i, i), 2);
    row.white = work.rests.noise.force[i] / (rest.end - rest.begin) +
                std::pow(floor_of_noise * work.options.gravity, 2) * row.unit;
  }
}

/// The Earth's rate about the vertical, and the sd of its unknown part about each axis.
double earth_up(const FitOptions& options) { return options.latitude ? earth_rate * std::sin(*options.latitude) : 0.0; }
double earth_sd(const FitOptions& options) {
  return options.latitude ? earth_rate * std::cos(*options.latitude) / std::sqrt(2.0) : earth_rate / std::sqrt(3.0);
}

/// The sd of the known part, by the latitude; small parts of it would only burden the solution.
double vertical_sd(const FitOptions& options) {
  return earth_rate * std::max(least_vertical_sd, std::cos(*options.latitude) * options.latitude_sd);
}

/// The Earth's rotation [rad/s] in the axes of a rest: by the moves since the first rest, else its part about the
/// vertical.
Vector3 earth_at(const Work& work, std::size_t pair) {
  const auto& from_first = work.fit.from_first[pair];
  return from_first ? *from_first * work.fit.earth : earth_up(work.options) * work.fit.direction[pair];
}

void set_rate(const Work& work, Group& group) {
  const Fit& fit = work.fit;
  const Rest& rest = work.rests.all[group.index];
  const Calibration& c = fit.calibration;
  const Vector3 earth = earth_at(work, group.pair), force = work.options.gravity * fit.direction[group.pair];
  const auto& from_first = fit.from_first[group.pair];
  const Vector3 residual = rest.rate - c.gyro.bias - c.sensitivity * force - c.gyro.matrix * earth;
  const Basis basis = across(fit.direction[group.pair]);
  group.first = of_accelerometers;
  group.columns = fit.unknowns() - group.first;
  group.rows.assign(3, {});
  for (std::size_t i = 0; i < 3; ++i) {
    Row& row = group.rows[i];
    row.residual = residual[i];
    for (std::size_t j = 0; j < 3; ++j) {
      row.common[gyro_index(i, j) - group.first] = earth[j];
      if (fit.parameters == with_sensitivity) row.common[gyro_index(i, 4 + j) - group.first] = force[j];
    }
    row.common[gyro_index(i, 3) - group.first] = 1.0;
    if (from_first) put(transposed(*from_first) * c.gyro.matrix[i], group.columns - 3, row);
    put_chain(basis, work.options.gravity * c.sensitivity[i], row);
    row.unit = dot(c.gyro.matrix[i], c.gyro.matrix[i]);
    row.white = work.rests.noise.rate[i] / (rest.end - rest.begin) + floor_of_noise * floor_of_noise * row.unit;
    row.earth = from_first ? 0.0 : std::pow(earth_sd(work.options), 2) * row.unit;
  }
}

/// Variance [rad^2/s] of the gyros' noise over a second of a move, mean of the axes.
double noise_of_turn(const Matrix3& inverse, Vector3 noise) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i) sum += dot(scaled(inverse[i], inverse[i]), noise) / 3.0;
  return sum;
}

void set_turn(const Work& work, Group& group) {
  Fit& fit = work.fit;
  const Move& move = fit.moves[group.index];
  Turn& turn = fit.turns[group.index];
  const Matrix3 to_rate = inverse(fit.calibration.gyro.matrix);
  const auto& from_first = fit.from_first[group.pair];
  const Vector3 n = fit.direction[group.pair];
  turn =
      turn_of(work.sessions[work.rests.all[move.from].session].gyro, move, fit.calibration, earth_at(work, group.pair));
  fit.from_first[group.pair + 1].reset();
  if (from_first && group.used) fit.from_first[group.pair + 1] = transposed(turn.rotation) * *from_first;
  const Basis before = across(n), after = across(fit.direction[group.pair + 1]);
  const double density = noise_of_turn(to_rate, work.rests.noise.rate);
  group.first = of_accelerometers;
  group.columns = fit.unknowns() - group.first;
  group.rows.assign(2, {});
  for (std::size_t i = 0; i < 2; ++i) {
    Row& row = group.rows[i];
    const Vector3 project = turn.rotation * after[i];  // in the axes at the beginning
    const Vector3 across_n = cross(n, project);        // -project' [n x]
    row.residual = -dot(project, n);
    for (std::size_t j = 0; j < (fit.parameters == with_sensitivity ? 7 : 4); ++j)
      put(transposed(to_rate) * (transposed(turn.turned[j]) * across_n), 3 * j, row);
    if (from_first) put(move.duration * (transposed(*from_first) * across_n), group.columns - 3, row);
    put_chain(before, project, row);
    row.chain[2 + i] = -1.0;
    row.white = density * move.duration + floor_of_noise * floor_of_noise;
    row.earth = from_first ? 0.0 : std::pow(earth_sd(work.options) * move.duration, 2);
    row.unit = std::max(turn.path * turn.path, least_path);
  }
}

/// Prior knowledge of the Earth's rotation: its part about the vertical of the first rest, and its size.
void set_earth(const Work& work, Group& group) {
  const Fit& fit = work.fit;
  const Vector3 up = fit.direction[0];
  const Basis level = across(up);
  const std::array<Vector3, 3> axes{up, level[0], level[1]};
  group.first = fit.parameters;
  group.columns = 3;
  group.rows.assign(3, {});
  for (std::size_t i = 0; i < 3; ++i) {
    Row& row = group.rows[i];
    put(axes[i], 0, row);
    row.residual = (i == 0 ? earth_up(work.options) : 0.0) - dot(axes[i], fit.earth);
    row.earth = std::pow(i == 0 && work.options.latitude ? vertical_sd(work.options) : earth_sd(work.options), 2);
  }
}

/// Moves come first: they show the orientation of each rest relative to the first.
void linearise(const Work& work) {
  for (Group& group : work.fit.groups)
    if (group.part == Part::turn) set_turn(work, group);
  for (Group& group : work.fit.groups) {
    if (group.part == Part::force) set_rest(work, group);
    if (group.part == Part::rate) set_rate(work, group);
    if (group.part == Part::earth) set_earth(work, group);
  }
}

/// Adds the columns of a matrix [3 x 3], from a parameter on.
void add_columns(const std::vector<double>& step, std::size_t from, Matrix3& to) {
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i < 3; ++i) to(i, j) += step[from + 3 * j + i];
}

void apply(const ChainSolution& step, Fit& fit) {
  const auto& p = step.parameters;
  Calibration& c = fit.calibration;
  add(p, c.accelerometer);
  if (fit.parameters > of_accelerometers) {
    add_columns(p, gyro_index(0, 0), c.gyro.matrix);
    for (std::size_t i = 0; i < 3; ++i) {
      c.gyro.bias[i] += p[gyro_index(i, 3)];
      fit.earth[i] += p[fit.parameters + i];
    }
  }
  if (fit.parameters == with_sensitivity) add_columns(p, gyro_index(0, 4), c.sensitivity);
  for (std::size_t k = 0; k < fit.direction.size(); ++k) {
    const Basis basis = across(fit.direction[k]);
    fit.direction[k] =
        normalised(fit.direction[k] + step.unknowns[2 * k] * basis[0] + step.unknowns[2 * k + 1] * basis[1]);
  }
}

constexpr double roughly = 1e-2, finely = 1e-4;  ///< of a standard deviation

/// Gauss-Newton steps until one would change every parameter by less than `close`, or `most`.
void iterate(const Work& work, int most, double close) {
  for (int i = 0; i < most; ++i) {
    const ChainSolution step = solve(normal_equations(work.fit), true);
    if (!step.positive_definite) throw_singular();
    double greatest = 0.0;
    for (std::size_t p = 0; p < step.parameters.size(); ++p)
      greatest = std::max(greatest, step.parameters[p] * step.parameters[p] / step.covariance(p, p));
    if (greatest < close * close) break;
    apply(step, work.fit);
    linearise(work);
  }
}

/// Bias and, where sought, G from the means at rest; single outliers weigh little.
void start_rates(const Work& work) {
  Fit& fit = work.fit;
  const std::size_t n = fit.chain.size(), columns = work.options.sensitivity ? 4 : 1;
  Matrix design(n, columns, 1.0), means(n, 3), solution;
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t j = 0; j < 3; ++j) {
      if (columns == 4) design(k, 1 + j) = work.options.gravity * fit.direction[k][j];
      means(k, j) = work.rests.all[fit.chain[k]].rate[j];
    }
  std::vector<double> weights(n, 1.0);
  for (int pass = 0; pass < passes_of_bias; ++pass) {
    solution = solve(scaled_rows(weights, design), scaled_rows(weights, means));
    const Matrix residual = means - design * solution;
    std::vector<double> sizes;
    for (std::size_t k = 0; k < n; ++k) sizes.push_back(norm(row(residual, k)));
    const double middle = std::max(median(sizes), 1e-300);
    for (std::size_t k = 0; k < n; ++k) weights[k] = std::sqrt(2.0 * middle / std::max(sizes[k], 2.0 * middle));
    fit.scatter[1] = middle * middle / 3.0;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    fit.calibration.gyro.bias[i] = solution(0, i);
    for (std::size_t j = 1; j < columns; ++j) fit.calibration.sensitivity(i, j - 1) = solution(j, i);
  }
}

void add_groups(Fit& fit) {
  for (std::size_t k = 0; k < fit.chain.size(); ++k) {
    fit.groups.push_back({.part = Part::force, .index = fit.chain[k], .pair = k});
    if (fit.parameters > of_accelerometers)
      fit.groups.push_back({.part = Part::rate, .index = fit.chain[k], .pair = k});
  }
  fit.from_first.resize(fit.chain.size());
  if (fit.parameters == of_accelerometers) return;
  fit.from_first[0] = identity3();
  fit.groups.push_back({.part = Part::earth});
  for (std::size_t m = 0; m < fit.moves.size(); ++m) {
    if (!fit.moves[m].used()) continue;
    const auto from = std::ranges::find(fit.chain, fit.moves[m].from) - fit.chain.begin();
    fit.groups.push_back({.part = Part::turn, .index = m, .pair = static_cast<std::size_t>(from)});
  }
}

void start_gyros(const Work& work) {
  Fit& fit = work.fit;
  start_rates(work);
  fit.moves = moves_between(work.sessions, work.rests, fit.calibration.accelerometer);
  const auto gyro = start_of_gyro(work.sessions, work.rests, fit.moves, fit.calibration);
  fit.gyros_without_turns = !gyro;
  if (!gyro) return;
  check_gyros(work.sessions[0], *gyro);
  fit.calibration.gyro.matrix = *gyro;
  double mean_square = 0.0;
  for (std::size_t i = 0; i < 3; ++i) mean_square += dot((*gyro)[i], (*gyro)[i]) / 3.0;
  fit.scatter[1] /= mean_square;
  fit.scatter[2] = start_of_turns;
  fit.parameters = work.options.sensitivity ? with_sensitivity : with_gyros;
}

void start(const Work& work) {
  Fit& fit = work.fit;
  std::vector<Vector3> means;
  for (std::size_t k = 0; k < work.rests.all.size(); ++k)
    if (work.rests.all[k].used()) fit.chain.push_back(k), means.push_back(work.rests.all[k].force);
  const auto sphere = fit_sphere(means, work.options.gravity);
  if (!sphere) throw_singular();
  check_force_unit(work.sessions[0], sphere->accelerometer.matrix);
  fit.calibration.accelerometer = sphere->accelerometer;
  const Inverse felt(sphere->accelerometer);
  for (const Vector3& mean : means) fit.direction.push_back(normalised(felt(mean)));
  fit.scatter[0] = sphere->scatter * sphere->scatter;
  if (!work.sessions[0].gyro.empty()) start_gyros(work);
  fit.turns.resize(fit.moves.size());
  add_groups(fit);
}

/// Rejects single groups whose distance is far beyond the median of their part. Returned: whether there was any.
bool reject_outliers(const Work& work) {
  constexpr std::array<double, 3> beyond{8.0, 4.5, 5.5};  // about 5.5 sigma for 1, 3 and 2 degrees of freedom
  bool any = false;
  for (const Part part : parts) {
    std::vector<double> distances;
    std::size_t rejected = 0;
    for (Group& group : work.fit.groups) {
      if (group.part != part) continue;
      group.distance = distance_of(group, work.fit);
      rejected += group.used ? 0 : 1;
      if (group.used) distances.push_back(group.distance);
    }
    if (distances.size() < fewest_of_part || rejected > distances.size() / most_rejected) continue;
    const double middle = median(distances), farthest = *std::ranges::max_element(distances);
    for (Group& group : work.fit.groups) {
      if (group.part != part || !group.used || group.distance < near_farthest * farthest) continue;
      if (group.distance <= beyond[static_cast<std::size_t>(part)] * std::max(middle, least_distance)) continue;
      group.used = false, any = true;
    }
  }
  return any;
}

void explain_rejections(const Work& work) {
  for (const Group& group : work.fit.groups) {
    if (group.used) continue;
    auto& why =
        group.part == Part::turn ? work.fit.moves[group.index].rejection : work.rests.all[group.index].rejection;
    if (why) continue;
    why = Finding(Finding::Severity::warning,
                  group.part == Part::force  ? "rest_off_gravity"
                  : group.part == Part::rate ? "rest_off_gyro_bias"
                                             : "move_off_rests",
                  {});
  }
}

}  // namespace

Fit fit_all(const std::vector<Session>& sessions, Rests& rests, const FitOptions& options) {
  Fit fit;
  const Work work{sessions, rests, options, fit};
  start(work);
  fit.earth = earth_up(options) * fit.direction[0];
  linearise(work);
  iterate(work, first_iterations, roughly);
  for (int pass = 0; pass < most_passes; ++pass) {
    find_scatter(1, fit);
    iterate(work, iterations_of_pass, roughly);
    if (!reject_outliers(work)) break;
    iterate(work, iterations_of_pass, roughly);
  }
  find_scatter(2, fit);
  iterate(work, last_iterations, finely);
  explain_rejections(work);
  add_uncertainty(rests.noise.degrees_of_freedom, fit);
  return fit;
}

}  // namespace tumble::imu_multi_position
