#include "tumble/exchange/testing/fleet.hpp"

#include <cmath>

#include "tumble/core/budget.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/answer.hpp"

namespace tumble::testing {
namespace {

Parameter fleet_parameter(const std::string& name, const std::string& unit) {
  Parameter out;
  out.name = out.symbol = name;
  out.unit = Unit::parse(unit);
  return out;
}

}  // namespace

FleetResult fleet_result(const FleetModel& model, const RandomStream& random, std::uint64_t unit, std::uint64_t rig,
                         const std::string& shows) {
  const auto own = random.split("unit").split(unit);
  const double u[3]{4.0, 3.0, 2.0};
  std::vector<double> theta;  // in the units shown
  const double common = own.normal(0);
  for (std::uint64_t k = 0; k < 3; ++k) {
    const double share = k < 2 ? model.correlation : 0.0;
    const double z = std::sqrt(share) * common + std::sqrt(1.0 - share) * own.normal(k + 1) + model.outside;
    theta.push_back(100.0 * static_cast<double>(k + 1) + model.spread * (k < 2 ? 1.0 : 1.0 / 3.0) * u[k] * z);
  }
  FleetResult out;
  Estimate& estimate = out.estimate;
  estimate.method = "accelerometer_tumble";
  estimate.instrument_model = "pendulous_accelerometer";
  estimate.instrument_serial = "U" + std::to_string(1000 + unit);
  estimate.parameters = {fleet_parameter("K0", "ug"), fleet_parameter("K1", "ppm"), fleet_parameter("K2", "ug/g^2")};
  Matrix noise(3, 3), level(3, 1), gravity(3, 1);
  const double scale = 0.7 + 0.8 * own.uniform(10);
  for (std::size_t k = 0; k < 3; ++k) noise(k, k) = scale * u[k];
  noise(1, 0) = 0.3 * scale * u[1];
  level(0, 0) = model.shared * u[0], level(1, 0) = 0.3 * model.shared * u[1];
  gravity(1, 0) = model.shared * u[1];
  if (shows == "K0 with K2")
    for (std::size_t k = 0; k < 3; ++k) noise(0, k) += 0.5 * noise(2, k);
  std::vector<double> draws{own.normal(20), own.normal(21), own.normal(22)};
  auto errors = noise * draws;
  const double z_level = random.split("level").normal(rig), z_gravity = random.split("gravity").normal(0);
  for (std::size_t k = 0; k < 3; ++k) errors[k] += level(k, 0) * z_level + gravity(k, 0) * z_gravity;
  std::vector<double> y = theta;
  if (shows == "K0 with K2") {
    y[0] += 0.5 * theta[2];
    estimate.parameters[0].contains = {
        {"K2", Unit::parse("ug/g^2"), 0.5 * Unit::parse("ug").factor() / Unit::parse("ug/g^2").factor()}};
  }
  const std::size_t p = shows == "all" ? 3 : 2;
  estimate.parameters.resize(p);
  std::vector<std::size_t> rows;
  std::vector<double> factors;
  for (std::size_t k = 0; k < p; ++k) {
    const Unit& shown = estimate.parameters[k].unit;
    estimate.parameters[k].value = shown.to_si(y[k] + errors[k]);
    rows.push_back(k), factors.push_back(shown.factor());
  }
  const auto si = [&](const Matrix& factor) { return scaled_rows(factors, chosen_rows(factor, rows)); };
  settle(estimate,
         {from_shifts("output noise", si(noise)), from_shifts("level", si(level), "rig " + std::to_string(rig)),
          from_shifts("gravity", si(gravity), "site")});
  const Unit shown[3]{Unit::parse("ug"), Unit::parse("ppm"), Unit::parse("ug/g^2")};
  for (std::size_t k = 0; k < 3; ++k) out.truth.push_back(shown[k].to_si(theta[k]));
  return out;
}

std::vector<FleetResult> fleet_results(const FleetModel& model, const RandomStream& random, std::uint64_t count) {
  std::vector<FleetResult> results;
  for (std::uint64_t i = 0; i < count; ++i) results.push_back(fleet_result(model, random, i, i % 2));
  return results;
}

Estimate single_result(double value, double sd, const std::string& rig, double rig_sd) {
  Estimate estimate;
  estimate.method = "static_bias";
  estimate.parameters = {fleet_parameter("bias", "deg/h")};
  const Unit& unit = estimate.parameters[0].unit;
  estimate.parameters[0].value = unit.to_si(value);
  std::vector<ErrorLine> lines{from_shifts("noise", Matrix(1, 1, unit.to_si(sd)))};
  if (rig_sd > 0.0) lines.push_back(from_shifts("rig", Matrix(1, 1, unit.to_si(rig_sd)), rig));
  settle(estimate, lines);
  return estimate;
}

}  // namespace tumble::testing
