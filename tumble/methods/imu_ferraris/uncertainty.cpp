#include "tumble/methods/imu_ferraris/uncertainty.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/earth/earth.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/symmetric_factor.hpp"
#include "tumble/methods/imu_ferraris/turn_causes.hpp"
#include "tumble/methods/imu_ferraris/warming.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/linear/slow.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_ferraris {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

Vector3 unit_vector(std::size_t axis) { return {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0}; }
/// Change of the unit vector along `axis` when it leans by these small angles toward the two others.
Vector3 lean(std::size_t axis, double first, double second) {
  const Vector3 leaning =
      unit_vector(axis) + first * unit_vector((axis + 1) % 3) + second * unit_vector((axis + 2) % 3);
  return (1.0 / norm(leaning)) * leaning - unit_vector(axis);
}

Cause accelerometer_noise(const Recorded& recorded) {
  Cause cause{"noise of the accelerometers", {}, 0.0, nullptr};
  for (std::size_t p = 0; p < poses; ++p) {
    for (std::size_t k = 0; k < 3; ++k) cause.sd.push_back(std::sqrt(variance(recorded, p, k)));
    cause.freedom += recorded.section[p].freedom[0];
  }
  cause.disturb = [](std::span<const double> z, Means& disturbed) {
    for (std::size_t p = 0; p < poses; ++p)
      for (std::size_t k = 0; k < 3; ++k) disturbed.force[p][k] += z[3 * p + k];
  };
  return cause;
}

/// Variance of the gyros' means over what their noise within the sections explains: the means of the two poses of each
/// axis agree but for noise and drift from section to section. Six degrees of freedom. Given: slow, variance of the
/// means of a pair about the mean of the three, by drift that is known.
double excess(const Means& means, const Recorded& recorded, const Vector3& slow = {}) {
  double ratio = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    std::array<double, 3> pair{};
    double noise = slow[k], squares = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      pair[axis] = 0.5 * (means.rate[2 * axis][k] + means.rate[2 * axis + 1][k]);
      noise += 0.25 * (variance(recorded, 2 * axis, 3 + k) + variance(recorded, 2 * axis + 1, 3 + k)) / 3.0;
    }
    const double mean = (pair[0] + pair[1] + pair[2]) / 3.0;
    for (const double v : pair) squares += (v - mean) * (v - mean) / 2.0;
    if (noise > 0.0) ratio += squares / noise / 3.0;
  }
  return ratio;
}

/// [1] The means of three pairs, which one drift moves one after the other, are no three draws of it.
constexpr double pairs_of_one_drift = 3.0;

/// White noise of the gyros, and with `larger` the drift that the poses show: the variance in units of the noise.
Cause gyro_noise(const Means& means, const Recorded& recorded, double larger, double freedom) {
  Cause cause{"noise and drift of the gyros", {}, freedom, nullptr};
  for (std::size_t p = 0; p < poses; ++p)
    for (std::size_t k = 3; k < outputs; ++k) cause.sd.push_back(std::sqrt(larger * variance(recorded, p, k)));
  for (std::size_t t = 0; t < turns; ++t)
    for (std::size_t k = 3; k < outputs; ++k) {  // as at rest: in a turn the noise cannot be separated from the motion
      double density = 0.0;
      for (std::size_t p = 0; p < poses; ++p) density += recorded.section[p].density[k] / poses;
      const auto samples = static_cast<double>(recorded.section[poses + t].samples);
      cause.sd.push_back(means.turn_time[t] * std::sqrt(larger * density / samples));
    }
  cause.disturb = [](std::span<const double> z, Means& disturbed) {
    for (std::size_t p = 0; p < poses; ++p)
      for (std::size_t k = 0; k < 3; ++k) disturbed.rate[p][k] += z[3 * p + k];
    for (std::size_t t = 0; t < turns; ++t)
      for (std::size_t k = 0; k < 3; ++k) disturbed.turned[t][k] += z[3 * (poses + t) + k];
  };
  return cause;
}

Cause tilts_of(const Calibration& c, const Squareness& square) {
  const Matrix3 force = response(c.k_a, c.r_a);
  return {"orientation of the poses", std::vector<double>(2 * poses, square.sd), square.freedom,
          [force, sensitivity = c.k_ga](std::span<const double> z, Means& means) {
            for (std::size_t p = 0; p < poses; ++p) {
              const Vector3 change = sign_of(p) * means.gravity * lean(axis_of(p), z[2 * p], z[2 * p + 1]);
              means.force[p] += force * change;
              if (means.gyros) means.rate[p] += sensitivity * change;
            }
          },
          true};
}

Cause gravity_cause(const Known& known) {
  Cause cause{"gravity", {known.sd}, infinite, [](std::span<const double> z, Means& means) { means.gravity += z[0]; }};
  if (known.origin.key != "gravity_unknown") cause.key = gravity_key(known.value);
  return cause;
}

Cause axes_of(const Calibration& c, double sd, double freedom) {
  return {"axes of the turns", std::vector<double>(2 * turns, sd), freedom,
          [rate = response(c.k_g, c.r_g)](std::span<const double> z, Means& means) {
            for (std::size_t t = 0; t < turns; ++t)
              means.turned[t] += means.angle[t] * rate * lean(t, z[2 * t], z[2 * t + 1]);
          },
          true};
}

Cause angles_of(double sd) {
  return {"angle of the turns", std::vector<double>(turns, sd), infinite, [](std::span<const double> z, Means& means) {
            for (std::size_t t = 0; t < turns; ++t) means.angle[t] += z[t];
          }};
}

/// The Earth's rate is in every output: along the vertical with the sign of the pose, and level in unknown directions.
Cause earth_of(const Plan& plan, const Calibration& c, const Means& means) {
  const double component = earth_rate / std::sqrt(3.0);
  double vertical = component, level = component;
  if (plan.site) {
    vertical = std::abs(earth_rate * std::sin(plan.site->latitude));
    level = earth_rate * std::cos(plan.site->latitude) / std::sqrt(2.0);
  }
  Cause cause{"Earth rate", {vertical}, infinite, nullptr};
  cause.sd.insert(cause.sd.end(), 2 * poses, level);
  for (std::size_t t = 0; t < turns; ++t) cause.sd.insert(cause.sd.end(), 3, component * means.turn_time[t]);
  cause.disturb = [rate = response(c.k_g, c.r_g)](std::span<const double> z, Means& disturbed) {
    for (std::size_t p = 0; p < poses; ++p) {
      const std::size_t axis = axis_of(p);
      const Vector3 felt = sign_of(p) * z[0] * unit_vector(axis) + z[1 + 2 * p] * unit_vector((axis + 1) % 3) +
                           z[2 + 2 * p] * unit_vector((axis + 2) % 3);
      disturbed.rate[p] += rate * felt;
    }
    for (std::size_t t = 0; t < turns; ++t) {
      const double* turn = z.data() + 1 + 2 * poses + 3 * t;
      disturbed.turned[t] += rate * Vector3{turn[0], turn[1], turn[2]};
    }
  };
  return cause;
}

/// Covariance of the means over the sections by flicker of unit bias instability; recordings are power-ups.
Matrix flicker_kernel(const Recorded& recorded, std::size_t count) {
  std::vector<linear::Interval> intervals;
  double step = 0.0;
  for (std::size_t s = 0; s < count; ++s) {
    for (const Part& part : recorded.section[s].pieces) intervals.push_back({part.recording, part.begin, part.length});
    step = std::max(step, recorded.section[s].time / static_cast<double>(recorded.section[s].samples));
  }
  NoiseModel unit;
  unit.bias_instability = 1.0;
  Matrix means(count, intervals.size());
  for (std::size_t s = 0, i = 0; s < count; ++s)
    for (const Part& part : recorded.section[s].pieces) means(s, i++) = part.length / recorded.section[s].time;
  return sandwich(means, linear::known_slow_noise(intervals, unit, 0.0, step).front().kernel);
}

/// A bias instability [SI], and the degrees of freedom that it is known with.
struct Instability {
  double value = 0.0, freedom = infinite;
};

/// Slow noise of three outputs by a bias instability. Scales: output for a unit of input.
Cause instability_of(const Recorded& recorded, const char* name, bool gyros, Instability known, Vector3 scale) {
  const std::size_t count = recorded.gyros ? sections : poses;
  const Matrix root = symmetric_factor(flicker_kernel(recorded, count)).factor;
  Cause cause{name, {}, known.freedom, nullptr};
  for (std::size_t k = 0; k < 3; ++k) cause.sd.insert(cause.sd.end(), root.columns, known.value * std::abs(scale[k]));
  cause.disturb = [root, gyros](std::span<const double> z, Means& means) {
    for (std::size_t s = 0; s < root.rows; ++s)
      for (std::size_t k = 0; k < 3; ++k) {
        double shift = 0.0;
        for (std::size_t c = 0; c < root.columns; ++c) shift += root(s, c) * z[k * root.columns + c];
        if (s < poses)
          (gyros ? means.rate[s] : means.force[s])[k] += shift;
        else if (gyros)
          means.turned[s - poses][k] += means.turn_time[s - poses] * shift;
        else
          means.turn_force[s - poses][k] += shift;
      }
  };
  return cause;
}

/// The bias instability of the accelerometers by the halves of the poses, three axes together. Means of two adjacent
/// halves differ by flicker with the variance 2 (2 ln 2/pi) B^2 = 0.88 B^2; the density from 16 blocks, which flicker
/// raises too, claims 0.23 B^2 of it for the noise (4/16 of their sample variance, (2 ln 2/pi) B^2 16 ln 16/(15 ln 4)).
Instability instability_of_halves(const Calibration& c, const Recorded& recorded) {
  constexpr double share_of_flicker = 0.65;
  double squares = 0.0, noise = 0.0, count = 0.0;
  for (std::size_t p = 0; p < poses; ++p)
    for (std::size_t k = 0; k < 3; ++k) {
      const Halves& halves = recorded.section[p].halves[k];
      const double unit = 1.0 / (c.k_a[k] * c.k_a[k]);
      squares += unit * halves.squares;
      noise += unit * recorded.section[p].density[k] * halves.noise;
      count += halves.count;
    }
  if (!(squares > noise)) return {};
  const double share = 1.0 - noise / squares;
  return {std::sqrt((squares - noise) / count / share_of_flicker), std::max(1.0, count * share * share)};
}

/// Slow noise of the accelerometers: as stated, or as the halves of the poses show it.
void add_accelerometer_instability(const Settings& settings, const Calibration& calibration, const Recorded& recorded,
                                   Findings& findings, std::vector<Cause>& all) {
  if (const double stated = linear::stated_bias_instability(settings, "accelerometer_"); stated > 0.0) {
    all.push_back(instability_of(recorded, "bias instability of the accelerometers, as stated", false, {stated},
                                 calibration.k_a));
    return;
  }
  const Instability shown = instability_of_halves(calibration, recorded);
  findings.push_back(
      {Finding::Severity::info, "accelerometer_instability_by_halves", {{"instability", shown.value, "ug"}}});
  if (shown.value > 0.0)
    all.push_back(instability_of(recorded, "bias instability of the accelerometers, by halves of the poses", false,
                                 shown, calibration.k_a));
}

/// The ratio of a variance to that of the noise which the noise alone exceeds in 1 % of all cases.
double significant_ratio(double freedom) { return chi_square_quantile(exceeded_in_100, freedom) / freedom; }

/// Variance of the means of pairs of poses about the mean of the three pairs, by flicker of unit bias instability.
double variance_of_pairs(const Recorded& recorded) {
  const Matrix kernel = flicker_kernel(recorded, poses);
  Matrix contrasts(3, poses);
  for (std::size_t p = 0; p < poses; ++p)
    for (std::size_t axis = 0; axis < 3; ++axis)
      contrasts(axis, p) = (axis_of(p) == axis ? 0.5 : 0.0) - 1.0 / static_cast<double>(poses);
  const Matrix of_pairs = sandwich(contrasts, kernel);
  return (of_pairs(0, 0) + of_pairs(1, 1) + of_pairs(2, 2)) / 2.0;
}

/// Noise and drift of the gyros: by the scatter of the poses; with a bias instability that is stated the poses only
/// have to agree with it.
void add_gyro_noise(const Settings& settings, const Means& means, const Calibration& calibration,
                    const Recorded& recorded, Findings& findings, std::vector<Cause>& all) {
  const double stated = linear::stated_bias_instability(settings, "gyro_");
  if (!(stated > 0.0)) {
    all.push_back(gyro_noise(means, recorded, shown_variance(means, recorded), 6.0));
    return;
  }
  const double pairs = variance_of_pairs(recorded);
  Vector3 slow;
  for (std::size_t k = 0; k < 3; ++k) slow[k] = pairs * std::pow(stated * calibration.k_g[k], 2);
  double freedom = 0.0;
  for (std::size_t p = 0; p < poses; ++p) freedom += recorded.section[p].freedom[3];
  all.push_back(instability_of(recorded, "bias instability of the gyros, as stated", true, {stated}, calibration.k_g));
  const double ratio = excess(means, recorded, slow);
  const bool more = ratio > chi_square_quantile(exceeded_in_1000, 6.0) / 6.0;
  if (more)
    findings.push_back({Finding::Severity::warning, "more_drift_than_stated", {{"times", std::sqrt(ratio)}}, "gyros"});
  all.push_back(more ? gyro_noise(means, recorded, excess(means, recorded), 6.0)
                     : gyro_noise(means, recorded, 1.0, freedom));
}

/// The tilt stated, compared with that of the poses; else that of the poses.
Squareness agreed(const Plan& plan, const Squareness& shown, Findings& findings) {
  const auto& settings = plan.settings;
  if (!settings.has("pose_sd")) {
    findings.push_back({Finding::Severity::info,
                        shown.sd > 0.0 ? "poses_aligned" : "poses_aligned_within_noise",
                        {{"sd", shown.sd, "deg"}}});
    return shown;
  }
  const double sd = settings.number("pose_sd");
  if (shown.sd > 0.0 && shown.sd * shown.sd > significant_ratio(6.0) * sd * sd)
    findings.push_back(
        {Finding::Severity::warning, "pose_sd_too_small", {{"sd", shown.sd, "deg"}, {"stated", sd, "deg"}}});
  return {sd, infinite};
}

}  // namespace

double variance(const Recorded& recorded, std::size_t section, std::size_t k) {
  const auto& s = recorded.section[section];
  return s.density[k] / static_cast<double>(s.samples);
}

double shown_variance(const Means& means, const Recorded& recorded) {
  const double ratio = excess(means, recorded);
  return ratio > chi_square_quantile(exceeded_in_1000, 6.0) / 6.0 ? pairs_of_one_drift * ratio : ratio;
}

Known gravity_of(const Plan& plan) {
  Known known{standard_gravity, tumble::gravity_sd({}), {"gravity_unknown"}};
  const auto& settings = plan.settings;
  if (settings.has("gravity"))
    known = {settings.number("gravity"), 100.0 * micro_g, {"gravity_from_settings"}};
  else if (plan.site)
    known = {gravity(*plan.site),
             rig_sd(plan, error_names::gravity).value_or(tumble::gravity_sd(plan.site)),
             {plan.site->gravity ? "gravity_measured_at_site" : "gravity_by_normal_formula"}};
  if (settings.has("gravity_sd")) known.sd = settings.number("gravity_sd");
  return known;
}

Squareness squareness(const Means& means, const Calibration& calibration, const Recorded& recorded) {
  double squares = 0.0, noise = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double g = calibration.k_a[k] * means.gravity;
    const double own = variance(recorded, 2 * k, k) + variance(recorded, 2 * k + 1, k);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis == k) continue;
      const double sum = means.force[2 * axis][k] + means.force[2 * axis + 1][k];
      const double across = (0.5 * sum - calibration.b_a[k]) / g;
      squares += across * across / 6.0;
      noise += 0.25 * (own + variance(recorded, 2 * axis, k) + variance(recorded, 2 * axis + 1, k)) / (g * g) / 6.0;
    }
  }
  if (squares <= noise) return {0.0, infinite};
  const double share = 1.0 - noise / squares;  // so that tilts and noise together have six degrees of freedom
  return {std::sqrt(2.0 * (squares - noise)), 6.0 * share * share};
}

std::vector<Cause> causes(const Plan& plan, const Means& means, const Calibration& calibration,
                          const Recorded& recorded, Findings& findings) {
  const auto& settings = plan.settings;
  const Squareness square = agreed(plan, squareness(means, calibration, recorded), findings);
  std::vector<Cause> all{accelerometer_noise(recorded), tilts_of(calibration, square), gravity_cause(gravity_of(plan))};
  add_accelerometer_instability(settings, calibration, recorded, findings, all);
  add_warming(recorded, findings, all);
  if (!means.gyros) return all;
  add_gyro_noise(settings, means, calibration, recorded, findings, all);
  const bool stated = settings.has("rotation_axis_sd");
  all.push_back(axes_of(calibration, stated ? settings.number("rotation_axis_sd") : square.sd,
                        stated ? infinite : square.freedom));
  all.push_back(angles_of(settings.number("rotation_angle_sd")));
  add_turn_causes(means, calibration, recorded, all);
  all.push_back(earth_of(plan, calibration, means));
  return all;
}

std::vector<double> signed_shift(const Cause& cause, const Means& means) {
  const auto with = [&](double sd) {
    Means disturbed = means;
    cause.disturb(std::vector{sd}, disturbed);
    return parameters_of(closed_form(disturbed));
  };
  // the parameters come out as with the disturbance taken away
  return scaled(0.5, difference(with(-cause.sd[0]), with(cause.sd[0])));
}

Moments moments_of(const Cause& cause, const Means& means) {
  std::vector<double> z(cause.sd.size(), 0.0);
  const auto parameters = [&] {
    Means disturbed = means;
    cause.disturb(z, disturbed);
    return parameters_of(closed_form(disturbed));
  };
  const auto middle = parameters();
  const std::size_t n = z.size();
  Moments out{Matrix(middle.size(), middle.size()), std::vector<double>(middle.size(), 0.0)};
  Matrix& moments = out.covariance;
  std::vector<std::vector<double>> plus(n), minus(n);
  for (std::size_t i = 0; i < n; ++i) {
    z[i] = cause.sd[i];
    plus[i] = parameters();
    z[i] = -cause.sd[i];
    minus[i] = parameters();
    z[i] = 0.0;
    add_square(moments, 0.25, difference(plus[i], minus[i]));
  }
  if (!cause.curved) return out;
  for (std::size_t i = 0; i < n; ++i) {
    const auto own = difference(scaled_sum(plus[i], 1.0, minus[i]), scaled(2.0, middle));
    out.shift = scaled_sum(out.shift, 0.5, own);
    add_square(moments, 0.5, own);
    for (std::size_t j = 0; j < i; ++j) {
      z[i] = cause.sd[i];
      z[j] = cause.sd[j];
      const auto mixed = scaled_sum(difference(difference(parameters(), plus[i]), plus[j]), 1.0, middle);
      z[i] = z[j] = 0.0;
      add_square(moments, 1.0, mixed);
    }
  }
  add_square(moments, 2.0 / cause.freedom, out.shift);
  return out;
}

}  // namespace tumble::imu_ferraris
