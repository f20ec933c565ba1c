#include "tumble/models/axes/axes.hpp"

#include <fmt/format.h>

#include <array>

#include "tumble/models/electronics/response.hpp"
#include "tumble/models/given/given.hpp"

namespace tumble::axes {
namespace {

using namespace given;
using Input::w_x, Input::a_x, Input::f_x;

constexpr std::array<char, 3> letters{'x', 'y', 'z'};

/// Bias, scale factor and misalignments of axis i of a triad that measures the field that begins with `field`.
std::vector<Term> linear_terms(const std::string& channel, std::size_t i, Input field, const char* bias_unit) {
  std::vector<Term> terms{
      {channel + "_bias", "b", bias_unit, "constant output", 1.0},
      {channel + "_scale_factor_error", "k", "ppm", "relative error of the scale factor", along(field, i)}};
  for (std::size_t j = 0; j < 3; ++j)
    if (j != i)
      terms.push_back({fmt::format("{}_misalignment_{}", channel, letters[j]), fmt::format("m_{}", letters[j]),
                       "arcsec", fmt::format("the input axis leans toward {}", letters[j]), along(field, j)});
  return terms;
}

/// Component i of a x r + w x (w x r) for a unit vector r along j.
Regressor lever_effect(std::size_t i, std::size_t j) {
  const std::size_t next = (i + 1) % 3, last = (i + 2) % 3;
  if (i == j) return -power(along(w_x, next), 2) - power(along(w_x, last), 2);
  const Regressor turning = along(w_x, i) * along(w_x, j);
  return j == last ? along(a_x, next) + turning : turning - along(a_x, last);
}

std::string prefix_of(QuantityKind kind) { return kind == QuantityKind::angular_rate ? "gyro_" : "accelerometer_"; }

}  // namespace

std::vector<Output> gyros() {
  std::vector<Output> outputs;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string channel = fmt::format("gyro_{}", letters[i]);
    auto terms = linear_terms(channel, i, w_x, "deg/h");
    for (std::size_t j = 0; j < 3; ++j)
      terms.push_back({fmt::format("{}_acceleration_sensitivity_{}", channel, letters[j]),
                       fmt::format("g_{}", letters[j]), "deg/h/g",
                       fmt::format("drift with the specific force along {}", letters[j]), along(f_x, j)});
    outputs.push_back({channel, QuantityKind::angular_rate, "deg/s", along(w_x, i), std::move(terms),
                       prefix_of(QuantityKind::angular_rate)});
  }
  return outputs;
}

std::vector<Output> accelerometers() {
  std::vector<Output> outputs;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string channel = fmt::format("accelerometer_{}", letters[i]);
    auto terms = linear_terms(channel, i, f_x, "mg");
    terms.push_back({channel + "_second_order_coefficient", "K_2", "ug/g^2", "square of the specific force",
                     power(along(f_x, i), 2)});
    for (std::size_t j = 0; j < 3; ++j)
      terms.push_back({fmt::format("{}_lever_{}", channel, letters[j]), fmt::format("r_{}", letters[j]), "mm",
                       fmt::format("position of this accelerometer along {} from the reference point", letters[j]),
                       lever_effect(i, j)});
    outputs.push_back({channel, QuantityKind::specific_force, "m/s^2", along(f_x, i), std::move(terms),
                       prefix_of(QuantityKind::specific_force)});
  }
  return outputs;
}

std::vector<Option> options(bool gyros, bool accelerometers) {
  std::vector<Option> out{
      word("output", {"rates", "increments"})
          .otherwise("rates")
          .says("content of a sample: the mean rate and specific force, or the angle and velocity increment")};
  const auto limits = [&](const std::string& prefix, const char* unit) {
    out.push_back(
        quantity(prefix + "range", unit).above(0).says("limit at which the output is clipped; default: no limit"));
    out.push_back(quantity(prefix + "resolution", unit).above(0).says("step of the output; default: none"));
  };
  const auto pulses = [&](const std::string& prefix, const char* unit, const char* of) {
    out.push_back(word(prefix + "output", {"as_output", "count"})
                      .otherwise("as_output")
                      .says("count: whole pulses in each sample; else as `output` says"));
    out.push_back(quantity(prefix + "pulse_scale_factor", unit).says(std::string("pulses per ") + of));
  };
  if (gyros) limits("gyro_", "deg/s");
  if (accelerometers) limits("accelerometer_", "g");
  if (gyros) pulses("gyro_", "pulse/arcsec", "angle turned");
  if (accelerometers) pulses("accelerometer_", "pulse/s/g", "velocity gained");
  return out;
}

namespace {

/// Whole pulses of each step, as of an I/F converter or a ring laser's counter.
Recorded counted(std::vector<Response> stages, const std::string& prefix, const Settings& truth, double step,
                 const RandomStream& random) {
  const std::string name = prefix + "pulse_scale_factor";
  if (given::number_or(truth, name, 0.0) == 0.0)
    given::refuse({say("{}output = \"count\" needs {}, not zero", prefix, Name{name})});
  stages.push_back(electronics::scaled(truth.number(name)));
  stages.push_back(electronics::pulse_counter(step, random.split("start phase").uniform(0)));
  return {QuantityKind::count, "pulse", true, electronics::in_series(std::move(stages))};
}

}  // namespace

Recorded record(const Output& output, const Settings& truth, double step, const RandomStream& random) {
  const std::string prefix = prefix_of(output.kind);
  std::vector<Response> stages;
  if (truth.has(prefix + "range")) {
    const double range = truth.number(prefix + "range");
    stages.push_back(electronics::clip(-range, range));
  }
  if (truth.has(prefix + "resolution")) stages.push_back(electronics::quantiser(truth.number(prefix + "resolution")));
  if (truth.word(prefix + "output") == "count") return counted(std::move(stages), prefix, truth, step, random);
  const bool increments = truth.word("output") == "increments";
  if (increments) stages.push_back(electronics::scaled(step));
  Recorded out{output.kind, output.unit, increments, electronics::in_series(std::move(stages))};
  if (increments) {
    const bool angle = output.kind == QuantityKind::angular_rate;
    out.kind = angle ? QuantityKind::angle : QuantityKind::velocity;
    out.unit = angle ? "deg" : "m/s";
  }
  return out;
}

}  // namespace tumble::axes
