#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/matrix3.hpp"
#include "tumble/methods/imu_channel_calibration/calibration.hpp"
#include "tumble/reduce/imu/axes_check.hpp"
#include "tumble/reduce/linear/joint.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_channel_calibration {
namespace {

constexpr double greatest_condition = 1e3;  ///< axes known to 1e-3: a weaker combination is made of their errors

/// y = u_i + b + k u_i + m_j u_j + m_l u_l, in the order bias, scale factor, misalignments; accelerometers also have
/// K_2, which (3.4) does not contain.
linear::Problem problem_of(Kind kind, std::size_t axis, const Settings& settings, const Channel& channel) {
  const std::string role = role_of(kind, axis);
  linear::Problem problem;
  problem.role = role;
  const Reading reading = reading_of(kind, settings, channel);
  problem.scale = reading.scale;
  problem.pulse = reading.pulse;
  problem.input = [=](const Felt& felt) { return imu::component(imu::field_of(kind, felt), axis); };
  linear::set_options(settings, problem, imu::prefix_of(kind));
  std::vector<std::string> names{role + "_bias", role + "_scale_factor_error"};
  for (const std::size_t which : {2u, 3u})
    names.push_back(fmt::format("{}_misalignment_{}", role, letters[other_axis(axis, which)]));
  if (kind == Kind::accelerometer) names.push_back(role + "_second_order_coefficient");
  problem.columns = linear::terms_of("imu", defaults(find_model("imu").constants()), names);
  problem.leave_out_first = {role + "_second_order_coefficient"};
  problem.condition_limit = greatest_condition;
  return problem;
}

/// Estimate of the channels: y = (1 + S) u + b, 12 terms.
struct Forward {
  std::vector<double> value, degrees_of_freedom;  ///< [12]
  std::vector<ErrorLine> lines;                   ///< of the 12
};

Forward forward_of(const linear::JointSolution& solution) {
  const auto& fit = solution.all.fit;
  Forward out;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < terms; ++i) {
    chosen.push_back(solution.first[i / per_axis] + i % per_axis);
    std::vector<double> weights(fit.parameters.size(), 0.0);
    weights[chosen.back()] = 1.0;
    out.value.push_back(fit.parameters[chosen.back()]);
    out.degrees_of_freedom.push_back(degrees_of_freedom(fit, weights));
  }
  out.lines = carried(chosen_rows(identity(fit.parameters.size()), chosen), lines_of(fit.sources));
  return out;
}

/// The 12 terms of a matrix without its identity and of a bias.
std::vector<double> terms_of(const Matrix3& matrix, Vector3 bias) {
  std::vector<double> out;
  for (std::size_t i = 0; i < 3; ++i)
    out.insert(out.end(), {bias[i], matrix(i, i), matrix(i, other_axis(i, 2)), matrix(i, other_axis(i, 3))});
  return out;
}

/// M = (1 + S)^-1, nabla = M b and their derivatives: dM = -M dS M, d nabla = M db - M dS M b.
struct Inverted {
  std::vector<double> value;  ///< [12]
  Matrix slope{terms, 0};     ///< [12 x 12]
};

Inverted inverted(const std::vector<double>& forward) {
  Matrix3 s = identity3();
  Vector3 b;
  for (std::size_t i = 0; i < 3; ++i) {
    b[i] = forward[index_of(i, 0)];
    s(i, i) += forward[index_of(i, 1)];
    for (const std::size_t which : {2u, 3u}) s(i, other_axis(i, which)) = forward[index_of(i, which)];
  }
  const Matrix3 m = inverse(s);
  const Vector3 nabla = m * b;
  Inverted out{.value = terms_of(m - identity3(), nabla)};
  const auto add_column = [&](const Matrix3& matrix, Vector3 bias) {
    out.slope = beside(out.slope, as_column(terms_of(matrix, bias)));
  };
  for (std::size_t p = 0; p < 3; ++p) {
    const Vector3 of_p = column(m, p);
    add_column({}, of_p);
    for (const std::size_t q : {p, other_axis(p, 2), other_axis(p, 3)})
      add_column(-outer(of_p, m[q]), -nabla[q] * of_p);
  }
  return out;
}

double temperature_of(const Evidence& whole, const linear::Solution& solution) {
  double sum = 0.0, count = 0.0;
  for (const auto& recording : whole.recordings)
    if (const Channel* channel = channel_for(whole, recording, "temperature"))
      for (const double v : channel->values)
        if (std::isfinite(v)) sum += v, count += 1.0;
  return count > 0.0 ? sum / count : solution.segments.front().felt.temperature;
}

void refuse_hidden(const std::vector<linear::Problem>& problems, const linear::JointSolution& solution) {
  Problems hidden;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const auto& dropped : solution.outputs[axis].dropped)
      if (dropped.column < per_axis)
        hidden.push_back(
            say("the schedule of the whole unit does not show {}", Name{problems[axis].columns[dropped.column].name}));
  if (hidden.empty()) return;
  hidden.push_back("six faces show all terms of accelerometers, rates of both signs about three axes those of gyros");
  throw Error(Error::Kind::bad_data, hidden);
}

/// Ranges of the regressors of the 12 terms in the test.
void set_limits(const std::vector<linear::Problem>& problems, const linear::JointSolution& solution, Calibration& out) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t a = 0; a < per_axis; ++a) {
      const linear::Solution& alone = solution.outputs[axis];
      const auto column = std::ranges::find(alone.columns, problems[axis].columns[a].name, &Term::name);
      const auto index = static_cast<std::size_t>(column - alone.columns.begin());
      out.least.push_back(alone.least[index]);
      out.greatest.push_back(alone.greatest[index]);
    }
}

/// Channels exchanged, reversed or in another unit than their names say.
Findings about_channels(Kind kind, const Forward& forward, const Evidence& whole) {
  Matrix response = identity(3);
  std::array<std::string, 3> names;
  for (std::size_t i = 0; i < 3; ++i) {
    response(i, i) += forward.value[index_of(i, 1)];
    for (const std::size_t which : {2u, 3u}) response(i, other_axis(i, which)) = forward.value[index_of(i, which)];
    names[i] = require_channel(whole, whole.recordings.front(), role_of(kind, i)).name;
  }
  return imu::about_axes(kind, imu::axes_seen(response), names);
}

}  // namespace

Calibration whole_of(Kind kind, const Evidence& all) {
  const Evidence whole = kind == Kind::accelerometer ? at_rest(all) : all;
  if (whole.recordings.empty())
    throw Error(Error::Kind::bad_data, "the recordings of the whole unit have no segment at rest");
  const Settings& settings = whole.plan.settings;
  std::vector<linear::Problem> problems;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Channel& channel = require_channel(whole, whole.recordings.front(), role_of(kind, axis));
    problems.push_back(problem_of(kind, axis, settings, channel));
  }
  const auto solution = linear::identify(whole, problems);
  refuse_hidden(problems, solution);
  const Forward forward = forward_of(solution);
  Calibration out;
  out.findings = solution.all.findings;
  for (auto& finding : about_channels(kind, forward, whole)) out.findings.push_back(std::move(finding));
  out.temperature = temperature_of(whole, solution.outputs.front());
  const Inverted result = inverted(forward.value);
  out.value = result.value;
  out.degrees_of_freedom = forward.degrees_of_freedom;
  set_limits(problems, solution, out);
  out.lines = carried(result.slope, forward.lines);
  return out;
}

}  // namespace tumble::imu_channel_calibration
