#include "tumble/models/axes/axes.hpp"

#include <fmt/format.h>

#include <array>

#include "tumble/models/electronics/response.hpp"
#include "tumble/models/given/given.hpp"

namespace tumble::axes {
namespace {

using namespace given;

constexpr std::array<char, 3> letters{'x', 'y', 'z'};

double component(Vector3 v, std::size_t axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

using Field = Vector3 Felt::*;

/// Bias, scale factor and misalignments of axis i of a triad that measures `field`.
std::vector<Term> linear_terms(const std::string& channel, std::size_t i, Field field, const char* bias_unit) {
  std::vector<Term> terms{{channel + "_bias", "b", bias_unit, "constant output", [](const Felt&) { return 1.0; }},
                          {channel + "_scale_factor_error", "k", "ppm", "relative error of the scale factor",
                           [=](const Felt& felt) { return component(felt.*field, i); }}};
  for (std::size_t j = 0; j < 3; ++j)
    if (j != i)
      terms.push_back({fmt::format("{}_misalignment_{}", channel, letters[j]), fmt::format("m_{}", letters[j]),
                       "arcsec", fmt::format("the input axis leans toward {}", letters[j]),
                       [=](const Felt& felt) { return component(felt.*field, j); }});
  return terms;
}

/// Component i of a x r + w x (w x r) for a unit vector r along j.
double lever_effect(const Felt& felt, std::size_t i, std::size_t j) {
  const Vector3 r{j == 0 ? 1.0 : 0.0, j == 1 ? 1.0 : 0.0, j == 2 ? 1.0 : 0.0};
  return component(cross(felt.angular_acceleration, r) + cross(felt.rate, cross(felt.rate, r)), i);
}

std::string prefix_of(QuantityKind kind) { return kind == QuantityKind::angular_rate ? "gyro_" : "accelerometer_"; }

}  // namespace

std::vector<Output> gyros() {
  std::vector<Output> outputs;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string channel = fmt::format("gyro_{}", letters[i]);
    auto terms = linear_terms(channel, i, &Felt::rate, "deg/h");
    for (std::size_t j = 0; j < 3; ++j)
      terms.push_back({fmt::format("{}_acceleration_sensitivity_{}", channel, letters[j]),
                       fmt::format("g_{}", letters[j]), "deg/h/g",
                       fmt::format("drift with the specific force along {}", letters[j]),
                       [=](const Felt& felt) { return component(felt.specific_force, j); }});
    outputs.push_back({channel, QuantityKind::angular_rate, "deg/s",
                       [=](const Felt& felt) { return component(felt.rate, i); }, std::move(terms),
                       prefix_of(QuantityKind::angular_rate)});
  }
  return outputs;
}

std::vector<Output> accelerometers() {
  std::vector<Output> outputs;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string channel = fmt::format("accelerometer_{}", letters[i]);
    auto terms = linear_terms(channel, i, &Felt::specific_force, "mg");
    terms.push_back(
        {channel + "_second_order_coefficient", "K_2", "ug/g^2", "square of the specific force", [=](const Felt& felt) {
           const double f = component(felt.specific_force, i);
           return f * f;
         }});
    for (std::size_t j = 0; j < 3; ++j)
      terms.push_back({fmt::format("{}_lever_{}", channel, letters[j]), fmt::format("r_{}", letters[j]), "mm",
                       fmt::format("position of this accelerometer along {} from the reference point", letters[j]),
                       [=](const Felt& felt) { return lever_effect(felt, i, j); }});
    outputs.push_back({channel, QuantityKind::specific_force, "m/s^2",
                       [=](const Felt& felt) { return component(felt.specific_force, i); }, std::move(terms),
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
    given::refuse({prefix + "output = \"count\" needs " + name + ", not zero"});
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
