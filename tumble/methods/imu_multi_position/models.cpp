#include <algorithm>

#include "tumble/methods/imu_multi_position/describe.hpp"
#include "tumble/reduce/imu/error_models.hpp"
#include "tumble/reduce/output_model.hpp"

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

}  // namespace

std::vector<OutputModel> models_of(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit,
                                   const Estimate& estimate) {
  const auto at_rest = in_rests(rests, fit);
  auto all = at_rest;
  add_moves(sessions, rests, fit, all);
  return imu::models_of(estimate, [&](const Term& term, imu::Kind kind) {
    const auto ranges = ranges_over({term}, kind == imu::Kind::gyro ? all : at_rest);
    return std::pair{ranges.least.front(), ranges.greatest.front()};
  });
}

}  // namespace tumble::imu_multi_position
