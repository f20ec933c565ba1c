#include <fmt/format.h>

#include <algorithm>

#include "tumble/methods/imu_multi_position/describe.hpp"
#include "tumble/reduce/imu/error_models.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_multi_position {
namespace {

std::vector<Felt> in_rests(const Rests& rests, const Fit& fit) {
  const Inverse force(fit.calibration.accelerometer);
  std::vector<Felt> all;
  for (const Rest& rest : rests.all) {
    if (!rest.used()) continue;
    Felt felt;
    felt.specific_force = force(rest.force);
    all.push_back(felt);
  }
  return all;
}

void add_moves(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit, std::vector<Felt>& all) {
  const Calibration& c = fit.calibration;
  const Inverse rate(c.gyro);
  for (const Move& move : fit.moves) {
    if (!move.used()) continue;
    const Triad& gyro = sessions[rests.all[move.from].session].gyro;
    for (std::size_t i = 0; i < move.force.size() && move.first + i < gyro.value.size(); ++i) {
      Felt felt;
      felt.specific_force = move.force[i];
      felt.rate = rate(gyro.value[move.first + i] - c.sensitivity * move.force[i]);
      all.push_back(felt);
    }
  }
}

bool counted(const Channel& channel) { return channel.kind == QuantityKind::count; }

}  // namespace

Table covered(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit, const Estimate& estimate) {
  const auto at_rest = in_rests(rests, fit);
  auto all = at_rest;
  add_moves(sessions, rests, fit, all);
  std::vector<Term> terms;
  std::vector<double> least, greatest;
  for (const auto& output : imu::error_models(estimate, {}).outputs)
    for (const Term& term : output.model.terms) {
      if (!find_parameter(estimate, term.name)) continue;
      double low = 1e300, high = -1e300;
      for (const Felt& felt : output.kind == imu::Kind::gyro ? all : at_rest) {
        const double x = term.regressor(felt);
        low = std::min(low, x), high = std::max(high, x);
      }
      terms.push_back(term);
      least.push_back(low);
      greatest.push_back(high);
    }
  return regressors_table(terms, least, greatest);
}

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan) {
  auto unit = imu::error_models(estimate, recording);
  Problems problems;
  for (const auto& output : unit.outputs) {
    const Channel* channel = channel_of(estimate, recording, output.model.role);
    if (channel && counted(*channel) == output.model.scale_factor.empty())
      problems.push_back(say("channel {} is in {}, but was calibrated in {}", channel->name, channel->unit.text(),
                             output.model.scale_factor.empty() ? "units of what it measures" : "raw counts"));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  return imu::compensate(std::move(unit), estimate, recording, plan);
}

}  // namespace tumble::imu_multi_position
