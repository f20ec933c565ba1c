#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tumble/core/budget.hpp"
#include "tumble/math/symmetric_factor.hpp"

/// A result as a method would return it, made up: what the reports are tested and looked at with. The numbers are the
/// size of a tactical fibre-optic gyro's; they come from closed formulas, so that every run has the same bytes.
namespace tumble::testing {

struct Line {
  const char *name, *symbol, *unit;
  double value, noise_sd, chamber_sd, repeat_sd;  ///< in unit
  const char* description;
  double degrees_of_freedom = INFINITY;
};

inline const std::vector<Line>& lines() {
  static const std::vector<Line> all{
      {"A1_0", "A1_0", "deg/h/K", 0.013482, 0.00021, 0.00009, 0.00005, "first order in temperature"},
      {"A1_1", "A1_1", "deg/h/K^2", -4.117e-5, 3.1e-6, 1.1e-6, 0.4e-6, "its slope with the start temperature"},
      {"A2_0", "A2_0", "deg/h/K^2", 2.0419e-4, 5.2e-6, 4.4e-6, 1.0e-6, "second order in temperature"},
      {"A3_0", "A3_0", "deg/h/K^3", -3.3e-7, 2.9e-7, 0.2e-7, 0.1e-7, "third order in temperature"},
      {"B1_0", "B1_0", "deg/h/K", 0.2071, 0.0040, 0.0110, 0.0020, "temperature gradient, top minus side", 28.0},
      {"B2_0", "B2_0", "deg/h/K^2", 0.00310, 0.00090, 0.00040, 0.00010, "square of the gradient", 28.0},
      {"C1_0", "C1_0", "deg/h/(K/min)", -1.9034, 0.0150, 0.0310, 0.0080, "rate of the temperature", 28.0},
      {"bias", "b", "deg/h", 0.4512, 0.0021, 0.0003, 0.0180, "bias at the reference temperature", 3.0},
      {"angle_random_walk", "N", "deg/sqrt(h)", 0.00512, 0.00004, 0.0, 0.00006, "angle random walk"},
      {"scale_factor_error", "E", "ppm", -132.7, 4.1, 21.0, 9.6, "scale factor error at 25 degC", 11.0},
      {"input_axis_misalignment", "δ_o", "arcsec", 12.0, 3.0, 14.0, 2.0, "input axis misalignment about o", 7.0},
      {"reference_temperature", "T_0", "degC", 24.93, 0.02, 0.05, 0.0, "mean temperature of the calibration"},
  };
  return all;
}

/// Deterministic, noise-like, within -1..1.
inline double wiggle(double n) {
  const double x = std::sin(12.9898 * n + 4.1) * 43758.5453;
  return 2.0 * (x - std::floor(x)) - 1.0;
}

inline void add_parameters(Estimate& e) {
  const auto count = lines().size();
  Matrix parts(count, 3);  // one standard deviation of each source
  for (std::size_t i = 0; i < count; ++i) {
    const auto& line = lines()[i];
    const auto unit = Unit::parse(line.unit);
    const double factor = unit.factor();
    e.parameters.push_back(
        {line.name, line.symbol, unit, unit.to_si(line.value), line.description, line.degrees_of_freedom});
    parts(i, 0) = line.noise_sd * factor, parts(i, 1) = line.chamber_sd * factor, parts(i, 2) = line.repeat_sd * factor;
  }
  const char* sources[] = {"output noise", "chamber and temperature sensors", "turn-on repeatability"};
  for (std::size_t k = 0; k < 3; ++k) {
    Matrix of_source(count, count);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j) {
        const double apart = std::abs(static_cast<double>(i) - static_cast<double>(j));
        of_source(i, j) = ((i + j) % 2 ? -1.0 : 1.0) * std::exp(-0.9 * apart) * parts(i, k) * parts(j, k);
      }
    e.budget.push_back({sources[k], k == 1 ? "chamber 7, certificate 2031" : "", symmetric_factor(of_source).factor});
  }
  e.covariance = covariance_of(e.budget, count);
}

// NOLINTNEXTLINE(readability-function-size): a list, one entry after another
inline void add_tables(Estimate& e) {
  const auto rate = Unit::parse("deg/h");
  Table models{"models",
               "Every model tried. The sd ratio is that of the residual to the raw output; held out: one run "
               "left out at a time.",
               {{"orders", {}},
                {"gradient", {}},
                {"rate", {}},
                {"sd", rate},
                {"sd ratio", {}},
                {"held-out sd", rate},
                {"AICc", {}},
                {"chosen", {}}},
               {}};
  for (int order = 1; order <= 4; ++order) {
    for (int terms = 0; terms < 3; ++terms) {
      const double ratio = (terms == 0 ? 0.81 : terms == 1 ? 0.52 : 0.31) - 0.011 * order;
      models.rows.push_back({static_cast<double>(order), std::string(terms > 0 ? "yes" : "no"),
                             std::string(terms > 1 ? "yes" : "no"), 0.0312 * ratio * rate.factor(), ratio,
                             (0.0312 * ratio + 0.0004 * order) * rate.factor(), -41230.0 + 2100.0 * ratio - order,
                             std::string(order == 3 && terms == 2 ? "chosen" : "")});
    }
  }
  Table runs{"runs",
             "",
             {{"run", {}},
              {"start temperature", Unit::parse("degC")},
              {"duration", Unit::parse("min")},
              {"mean", rate},
              {"sd before", rate},
              {"sd after", rate}},
             {}};
  for (int run = 1; run <= 64; ++run) {
    const int step = (run - 1) / 8;
    runs.rows.push_back({static_cast<double>(run), 253.15 + 10.0 * step + 0.1 * wiggle(run), 7200.0,
                         (0.45 + 0.02 * wiggle(run + 0.5)) * rate.factor(),
                         (0.031 + 0.003 * wiggle(run + 0.25)) * rate.factor(),
                         run == 17 ? NAN : (0.0097 + 0.001 * wiggle(run + 0.75)) * rate.factor()});
  }
  Table channels{"channels",
                 "What was read.",
                 {{"role", {}}, {"channel", {}}, {"rate", Unit::parse("Hz")}, {"samples", {}}},
                 {{std::string("gyro"), std::string("fog.x"), 1.0, 460800.0},
                  {std::string("temperature_top"), std::string("t.top"), 1.0, 460800.0},
                  {std::string("temperature_side"), std::string("t.side"), 0.1, 46080.0}}};
  e.tables = {models, runs, channels};
}

inline Curve drift(const char* name, double scale, std::size_t samples) {
  Curve c{
      name, "Output over time", {"time", Unit::parse("h"), {}}, {"rate", Unit::parse("deg/h"), {}}, {}, {}, "", false,
      false};
  for (std::size_t i = 0; i < samples; ++i) {
    const double hours = 2.0 * static_cast<double>(i) / static_cast<double>(samples);
    const double trend = scale * 0.09 * (1.0 - std::exp(-2.0 * hours)) + 0.45;
    c.x.values.push_back(hours * 3600.0);
    c.y.values.push_back(c.y.unit.to_si(trend + 0.02 * wiggle(static_cast<double>(i) + scale)));
  }
  return c;
}

inline void add_allan(Estimate& e) {
  const auto rate = Unit::parse("deg/h");
  Curve data{"measured",
             "Allan deviation",
             {"averaging time", Unit::parse("s"), {}},
             {"Allan deviation", rate, {}},
             {},
             {},
             "95 % confidence",
             true,
             true};
  Curve model = data;
  model.name = "fitted terms";
  model.points = false;
  model.band = "95 % of the fit";
  for (int k = 0; k <= 36; ++k) {
    const double tau = std::pow(10.0, k / 9.0);
    const double sd = std::hypot(0.307 / std::sqrt(tau), 0.0021, 1.1e-5 * std::sqrt(tau) * 3.0);
    const double spread = 0.008 * std::sqrt(tau);
    data.x.values.push_back(tau);
    model.x.values.push_back(tau);
    data.y.values.push_back(rate.to_si(sd * (1.0 + 0.6 * spread * wiggle(k))));
    data.lower.push_back(data.y.values.back() / (1.0 + spread));
    data.upper.push_back(data.y.values.back() * (1.0 + spread));
    model.y.values.push_back(rate.to_si(sd));
    model.lower.push_back(rate.to_si(sd / (1.02 + 0.3 * spread)));
    model.upper.push_back(rate.to_si(sd * (1.02 + 0.3 * spread)));
  }
  e.curves.push_back(model);
  e.curves.push_back(data);
}

// NOLINTNEXTLINE(readability-function-size): a list, one entry after another
inline void add_curves(Estimate& e) {
  e.curves.push_back(drift("before", 1.0, 7200));
  e.curves.push_back(drift("after compensation", 0.0, 7200));
  add_allan(e);
  const auto rate = Unit::parse("deg/h");
  Curve surface{"model",
                "Bias over temperature",
                {"temperature", Unit::parse("degC"), {}},
                {"bias", rate, {}},
                {},
                {},
                "95 % of the model",
                false,
                false};
  Curve points = surface;
  points.name = "run means";
  points.points = true;
  points.band = "95 % of each mean";
  for (int t = -20; t <= 60; ++t) {
    const double bias = 0.45 + 0.0135 * (t - 25) / 10.0 + 2.0e-5 * (t - 25) * (t - 25);
    const double half = 0.006 + 6e-6 * (t - 20) * (t - 20);
    surface.x.values.push_back(t + 273.15);
    surface.y.values.push_back(rate.to_si(bias));
    surface.lower.push_back(rate.to_si(bias - half));
    surface.upper.push_back(rate.to_si(bias + half));
    if (t % 10 == 0) {
      points.x.values.push_back(t + 273.15);
      points.y.values.push_back(rate.to_si(bias + 0.6 * half * wiggle(t)));
      points.lower.push_back(points.y.values.back() - rate.to_si(0.008));
      points.upper.push_back(points.y.values.back() + rate.to_si(0.008));
    }
  }
  e.curves.push_back(surface);
  e.curves.push_back(points);
  Curve residual{
      "residual", "Residuals over run", {"run", {}, {}}, {"residual", Unit::parse("arcsec/s"), {}}, {}, {}, "", false,
      true};
  for (int run = 1; run <= 32; ++run) {
    residual.x.values.push_back(run);
    residual.y.values.push_back(rate.to_si(0.01 * wiggle(run + 0.125)));
  }
  e.curves.push_back(residual);
}

inline void add_models(Estimate& e) {
  e.models = {{.role = "gyro",
               .shows = Input::rate_x,
               .unit = Unit::parse("deg/h"),
               .recorded = Unit::parse("deg/h"),
               .covered = {{{{Input::temperature, 1.0}}, si(-20.0, "degC"), si(60.0, "degC")}},
               .terms = {{.term = "bias",
                          .parameter = 7,
                          .regressor = {{1.0, {{.input = Input::temperature, .origin = si(20.0, "degC")}}}},
                          .least = -40.0,
                          .greatest = 40.0}}}};
}

inline Estimate estimate() {
  Estimate e;
  e.method = "fog_thermal_bias";
  e.title = "Thermal bias of a fibre-optic gyro, eight start temperatures";
  e.instrument_model = "fiber_optic_gyro";
  e.instrument_serial = "FOG-0117";
  add_parameters(e);
  add_tables(e);
  add_models(e);
  add_curves(e);
  e.fit = {460800, 460789.0, 461512.4, 18.3};
  using Severity = Finding::Severity;
  e.findings.push_back(Finding(Severity::warning, "gap", {{"lost", 34}, {"longest", 0.31, "s"}}, "t.top",
                               Occurrences{3, Place(812.4), Place(4120.0)}));
  e.findings.push_back(Finding(Severity::info, "decimal_comma", {}, "runs/fog-0117-1.csv"));
  e.findings.push_back(Finding(
      Severity::error, "counter_overflow",
      {{"bits", 16}, {"register", Phrase{"signed_register"}}, {"counts", -32700}, {"before", 32750}, {"size", 65536}},
      "fog.x", Occurrences{1, Place("run 12", 812.4), Place()}));
  e.findings.push_back(Finding(Severity::warning, "outlier",
                               {{"distance", 31.5, Unit::parse("deg/h")}, {"times", 12.5}}, "fog.x",
                               Occurrences{1, Place(), Place("run 3")}));
  e.verdicts = {{"bias", Verdict::Outcome::pass, {.upper = bound(0.6, "deg/h")}},
                {"scale_factor_error", Verdict::Outcome::fail, {.lower = bound(-50.0, "ppm")}},
                {"input_axis_misalignment", Verdict::Outcome::undecided, {.upper = bound(20.0, "arcsec")}}};
  e.provenance.inputs = {{"runs/fog-0117-1.csv", "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"},
                         {"runs/fog-0117-2.csv", "60303ae22b998861bce3b28f33eec1be758a213c86c93c076dbe9f558c11c752"}};
  e.provenance.plans = {
      {"fog-0117.toml", "2c26b46b68ffc68ff99b453c1d30413413422d706483bfa0f98a5e886266e7ae",
       "title = \"<b> & 'c'\"\nmethod = \"fog_thermal_bias\"\n"},
      {"long.toml", "fcde2b2edba56bf408601fb721fe9b5c338d10ee429ea04fae5511b68fbf8fb9", std::nullopt}};
  e.provenance.command_line = {{"smoothing_time", "60 s"}};
  e.provenance.settings = {{"estimator", "joint"}, {"orders", "choose"}, {"smoothing_time", "60 s"}};
  e.provenance.seed = 18446744073709551615ull;
  return e;
}

}  // namespace tumble::testing
