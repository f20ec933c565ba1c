#include "tumble/exchange/exports/c_code/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/error.hpp"

namespace tumble::c_code {

bool has_curve(const TriadCalibration& triad) {
  return std::ranges::any_of(triad.curve, [](const OwnCurve& curve) { return !curve.is_zero(); });
}

bool has_temperature(const TriadCalibration& triad) {
  return std::ranges::any_of(triad.thermal, [](const AxisThermal& axis) {
    return !axis.output.empty() || !axis.scale.empty() || !axis.bias.empty();
  });
}

bool has_temperature(const ImuCalibration& calibration) {
  return has_temperature(calibration.accelerometers) || has_temperature(calibration.gyros);
}

namespace {

/// Greatest |dq/du| over a range of +-r.
double slope(const OwnCurve& curve, double r) {
  double sum = std::abs(curve.magnitude) + 2.0 * std::abs(curve.signed_square) * r, power = r;
  for (std::size_t k = 0; k < curve.power.size(); ++k, power *= r)
    sum += static_cast<double>(k + 2) * std::abs(curve.power[k]) * power;
  return sum + curve.table.steepest();
}

}  // namespace

bool has_terms(const TriadCalibration& triad) {
  return std::ranges::any_of(triad.curve, [](OwnCurve curve) {
    curve.table = {};
    return !curve.is_zero();
  });
}

std::size_t table_points(const TriadCalibration& triad) {
  std::size_t most = 0;
  for (const OwnCurve& curve : triad.curve) most = std::max(most, curve.table.at.size());
  return most;
}

TableRows table_rows(const TriadCalibration& triad) {
  TableRows rows;
  for (const OwnCurve& curve : triad.curve) {
    const auto& [at, departure] = curve.table;
    rows.points.push_back(at.size());
    rows.at.push_back(at);
    rows.departure.push_back(departure);
    rows.slope.emplace_back(at.empty() ? 0 : 1, 0.0);
    for (std::size_t k = 1; k < at.size(); ++k)
      rows.slope.back().push_back((departure[k] - departure[k - 1]) / (at[k] - at[k - 1]));
    for (auto* row : {&rows.at.back(), &rows.departure.back(), &rows.slope.back()}) row->resize(table_points(triad));
  }
  return rows;
}

int exponent_above(double value) { return static_cast<int>(std::ceil(std::log2(std::max(value, 1e-30)))); }

int temperature_exponent(const ImuCalibration& c) {
  constexpr int unknown = 10;  // 1024 K: the results do not say what they cover
  if (std::isnan(c.coldest) || std::isnan(c.hottest)) return unknown;
  const double reach =
      std::max(std::abs(c.hottest - c.reference_temperature), std::abs(c.coldest - c.reference_temperature));
  return std::clamp(exponent_above(reach), 0, 14);
}

int curve_exponent(const TriadCalibration& triad, std::size_t axis) { return exponent_above(1.1 * triad.range[axis]); }

int passes_of(const TriadCalibration& triad, const char* what, double rounding) {
  if (!has_curve(triad)) return 0;
  constexpr double most = 0.3;
  const Matrix3 inverted = inverse(triad.response);
  double ratio = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j < 3; ++j) sum += std::abs(inverted(i, j)) * slope(triad.curve[j], 1.1 * triad.range[j]);
    ratio = std::max(ratio, sum);
  }
  const bool is_gyro = std::string_view(what) == "gyro";
  if (ratio > most)
    throw Error(Error::Kind::bad_input,
                say("the nonlinearity of the {} changes their scale factor by {:.2g} over the range: too much "
                    "for code without a solver; state a smaller {}_range",
                    is_gyro ? "gyros" : "accelerometers", ratio, Name{is_gyro ? "rate" : "force"}));
  return ratio > 0.0 ? 1 + static_cast<int>(std::ceil(std::log(rounding) / std::log(ratio))) : 0;
}

std::string filled(std::string text, const std::vector<std::pair<std::string, std::string>>& values) {
  for (const auto& [key, value] : values)
    for (auto at = text.find(key); at != std::string::npos; at = text.find(key, at + value.size()))
      text.replace(at, key.size(), value);
  return text;
}

std::vector<TestVector> test_vectors(const ImuCalibration& calibration) {
  constexpr int count = 32;
  // fractions of irrational numbers fill the seven dimensions evenly
  constexpr double steps[] = {0.414213562, 0.732050808, 0.236067977, 0.645751311,
                              0.316624790, 0.605551275, 0.123105626};
  const auto share = [&](int k, int dimension) { return 2.0 * std::fmod(k * steps[dimension] + 0.5, 1.0) - 1.0; };
  const bool temperatures = !std::isnan(calibration.coldest) && !std::isnan(calibration.hottest);
  std::vector<TestVector> vectors;
  for (int k = 0; k < count; ++k) {
    ImuSample truth;
    for (std::size_t i = 0; i < 3; ++i) {
      truth.force[i] = calibration.accelerometers.range[i] * share(k, static_cast<int>(i));
      truth.rate[i] = calibration.gyros.range[i] * share(k, static_cast<int>(i) + 3);
    }
    if (temperatures)
      truth.temperature = 0.5 * (calibration.coldest + calibration.hottest) +
                          0.5 * (calibration.hottest - calibration.coldest) * share(k, 6);
    vectors.push_back({outputs_of(calibration, truth), truth});
  }
  return vectors;
}

}  // namespace tumble::c_code
