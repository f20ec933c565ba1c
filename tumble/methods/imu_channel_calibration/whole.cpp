#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/methods/imu_channel_calibration/calibration.hpp"
#include "tumble/reduce/linear/joint.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_channel_calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// y = u_i + b + k u_i + m_j u_j + m_l u_l, in the order bias, scale factor, misalignments; accelerometers with K_2 as
/// well, which is not of (3.4).
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
  problem.condition_limit = 1e3;
  return problem;
}

/// What was found of the channels: y = (1 + S) u + b, one column of 12, and its covariance by source.
struct Forward {
  VectorXd value = VectorXd(at(terms));
  std::vector<double> degrees_of_freedom;
  std::vector<std::pair<std::string, MatrixXd>> sources;
};

Forward forward_of(const linear::JointSolution& solution) {
  const auto& fit = solution.all.fit;
  MatrixXd pick = MatrixXd::Zero(at(terms), at(fit.parameters.size()));
  Forward out;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t a = 0; a < per_axis; ++a) {
      const std::size_t from = solution.first[axis] + a;
      std::vector<double> one(fit.parameters.size(), 0.0);
      one[from] = 1.0;
      pick(at(index_of(axis, a)), at(from)) = 1.0;
      out.value[at(index_of(axis, a))] = fit.parameters[from];
      out.degrees_of_freedom.push_back(degrees_of_freedom(fit, one));
    }
  for (const auto& source : fit.sources)
    out.sources.emplace_back(source.source, pick * map(source.covariance) * pick.transpose());
  return out;
}

/// M = (1 + S)^-1, nabla = M b and their derivatives: dM = -M dS M, d nabla = M db - M dS M b.
struct Inverted {
  VectorXd value = VectorXd(at(terms));
  MatrixXd slope = MatrixXd::Zero(at(terms), at(terms));
};

std::size_t column_of(std::size_t axis, std::size_t which) { return which == 1 ? axis : other_axis(axis, which); }

Inverted inverted(const VectorXd& forward) {
  Eigen::Matrix3d s = Eigen::Matrix3d::Identity();
  Eigen::Vector3d b;
  for (std::size_t i = 0; i < 3; ++i) {
    b[at(i)] = forward[at(index_of(i, 0))];
    for (const std::size_t which : {1u, 2u, 3u}) s(at(i), at(column_of(i, which))) += forward[at(index_of(i, which))];
  }
  const Eigen::Matrix3d m = s.inverse();
  const Eigen::Vector3d nabla = m * b;
  Inverted out;
  const auto put = [](const Eigen::Matrix3d& matrix, const Eigen::Vector3d& bias, auto&& to) {
    for (std::size_t i = 0; i < 3; ++i) {
      to(index_of(i, 0), bias[at(i)]);
      for (const std::size_t which : {1u, 2u, 3u}) to(index_of(i, which), matrix(at(i), at(column_of(i, which))));
    }
  };
  put(m - Eigen::Matrix3d::Identity(), nabla, [&](std::size_t k, double v) { out.value[at(k)] = v; });
  for (std::size_t p = 0; p < 3; ++p) {
    const auto bias_column = [&](std::size_t k, double v) { out.slope(at(k), at(index_of(p, 0))) = v; };
    put(Eigen::Matrix3d::Zero(), m.col(at(p)), bias_column);
    for (const std::size_t which : {1u, 2u, 3u}) {
      const std::size_t q = column_of(p, which);
      const auto column = [&](std::size_t k, double v) { out.slope(at(k), at(index_of(p, which))) = v; };
      put(-m.col(at(p)) * m.row(at(q)), -m.col(at(p)) * nabla[at(q)], column);
    }
  }
  return out;
}

double temperature_of(const Evidence& whole, const linear::Solution& solution) {
  double sum = 0.0, count = 0.0;
  for (const auto& recording : whole.recordings)
    if (const Channel* channel = channel_for(whole, recording, "temperature"))
      for (const double v : channel->values)
        if (std::isfinite(v)) {
          sum += v;
          count += 1.0;
        }
  return count > 0.0 ? sum / count : solution.segments.front().felt.temperature;
}

void refuse_hidden(const std::vector<linear::Problem>& problems, const linear::JointSolution& solution) {
  std::vector<std::string> hidden;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const auto& dropped : solution.outputs[axis].dropped)
      if (dropped.column < per_axis)
        hidden.push_back(fmt::format("the schedule of the whole unit does not show {}",
                                     problems[axis].columns[dropped.column].name));
  if (hidden.empty()) return;
  hidden.push_back("six faces show all terms of accelerometers, rates of both signs about three axes those of gyros");
  throw Error(Error::Kind::bad_data, hidden);
}

/// What the regressors of the 12 terms were in the test.
void set_limits(const std::vector<linear::Problem>& problems, const linear::JointSolution& solution, Calibration& out) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t a = 0; a < per_axis; ++a) {
      const linear::Solution& alone = solution.outputs[axis];
      const auto column = std::ranges::find(alone.columns, problems[axis].columns[a].name, &Term::name);
      const auto at = static_cast<std::size_t>(column - alone.columns.begin());
      out.least.push_back(alone.least[at]);
      out.greatest.push_back(alone.greatest[at]);
    }
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
  out.temperature = temperature_of(whole, solution.outputs.front());
  const Inverted result = inverted(forward.value);
  out.value.assign(result.value.data(), result.value.data() + result.value.size());
  out.degrees_of_freedom = forward.degrees_of_freedom;
  set_limits(problems, solution, out);
  for (const auto& [name, covariance] : forward.sources)
    out.sources.push_back({name, plain(result.slope * covariance * result.slope.transpose())});
  return out;
}

}  // namespace tumble::imu_channel_calibration
