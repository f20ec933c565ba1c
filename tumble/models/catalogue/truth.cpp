#include "tumble/core/find.hpp"
#include "tumble/models/model.hpp"

namespace tumble {
namespace {

Option quantity(std::string name, std::string unit, std::string description, std::string fallback = {}) {
  if (fallback.empty()) fallback = "0 " + unit;
  return {std::move(name), Option::Type::quantity, std::move(unit), std::move(fallback), {}, std::move(description)};
}

/// Units in which people quote the noise of an angular rate or a specific force.
std::vector<Option> noise_options(QuantityKind output) {
  const bool rate = output == QuantityKind::angular_rate;
  const std::string u = rate ? "deg/h" : "ug";
  const std::string walk = rate ? "deg/sqrt(h)" : "(m/s)/sqrt(h)";
  return {quantity("quantization_noise", rate ? "arcsec" : "mm/s", "Q: white noise of the integrated output"),
          quantity("angle_random_walk", walk, "N: white noise of the output"),
          quantity("bias_instability", u, "B: flicker noise; the flat part of the Allan deviation is 0.664 B"),
          quantity("rate_random_walk", u + "/sqrt(h)", "K: random walk of the output since power-on"),
          quantity("rate_ramp", u + "/h", "R: linear drift"),
          quantity("markov_sd", u, "standard deviation of a first-order Markov process"),
          quantity("markov_time", "s", "its correlation time", "100 s"),
          quantity("turn_on_repeatability", u, "standard deviation of the bias from power-up to power-up")};
}

}  // namespace

std::vector<Option> truth_options(const Model& model) {
  auto options = model.constants();
  for (const auto& term : model.terms(defaults(options)))
    options.push_back(quantity(term.name, term.unit, term.description));
  for (auto& option : noise_options(model.output)) options.push_back(std::move(option));
  return options;
}

NoiseModel noise_of(const Settings& truth) {
  return {truth.number("quantization_noise"), truth.number("angle_random_walk"), truth.number("bias_instability"),
          truth.number("rate_random_walk"),   truth.number("rate_ramp"),         truth.number("markov_sd"),
          truth.number("markov_time")};
}

const Model& find_model(std::string_view name) { return find_entry(models::catalogue(), name, "model"); }

}  // namespace tumble
