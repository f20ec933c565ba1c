#include "tumble/models/model.hpp"

#include <set>

#include "tumble/core/find.hpp"

namespace tumble {
namespace {

/// Units in which people quote the noise of an angular rate or a specific force.
std::vector<Option> noise_options(QuantityKind output, const std::string& prefix) {
  const bool rate = output == QuantityKind::angular_rate;
  const std::string u = rate ? "deg/h" : "ug";
  const std::string walk = rate ? "deg/sqrt(h)" : "(m/s)/sqrt(h)";
  const auto zero = [&](const char* name, const std::string& unit, const char* description) {
    return quantity(prefix + name, unit).otherwise("0 " + unit).says(description);
  };
  const auto deviation = [&](const char* name, const std::string& unit, const char* description) {
    return zero(name, unit, description).at_least(0);
  };
  return {
      deviation("quantization_noise", rate ? "arcsec" : "mm/s", "Q: white noise of the integrated output"),
      deviation("angle_random_walk", walk, "N: white noise of the output"),
      deviation("bias_instability", u, "B: flicker noise; the flat part of the Allan deviation is 0.664 B"),
      deviation("rate_random_walk", u + "/sqrt(h)", "K: random walk of the output since power-on"),
      zero("rate_ramp", u + "/h", "R: linear drift"),
      deviation("markov_sd", u, "standard deviation of a first-order Markov process"),
      quantity(prefix + "markov_time", "s").above(0).otherwise("100 s").says("correlation time of the Markov process"),
      deviation("turn_on_repeatability", u, "standard deviation of the bias from power-up to power-up")};
}

/// The outputs under every choice of each word among the constants: a choice may bring outputs with terms of its own.
std::vector<Output> all_outputs(const Model& model) {
  const auto constants = model.constants();
  auto outputs = model.outputs(defaults(constants));
  for (const auto& option : constants)
    for (const auto& word : option.words) {
      auto chosen = defaults(constants);
      chosen.set_word(option.name, word);
      for (auto& output : model.outputs(chosen)) outputs.push_back(std::move(output));
    }
  return outputs;
}

}  // namespace

std::vector<Option> truth_options(const Model& model) {
  auto options = model.constants();
  const auto outputs = all_outputs(model);
  if (model.physics)
    for (auto& option : model.physics()) options.push_back(std::move(option));
  std::set<std::string> names;
  for (const auto& output : outputs)
    for (const auto& term : output.terms)  // without a physics that could say otherwise an absent coefficient is 0
      if (names.insert(term.name).second)
        options.push_back(
            quantity(term.name, term.unit).otherwise(model.physics ? "" : "0 " + term.unit).says(term.description));
  std::set<std::string> prefixes;
  for (const auto& output : outputs)
    if (prefixes.insert(output.noise_prefix).second)
      for (auto& option : noise_options(output.kind, output.noise_prefix)) options.push_back(std::move(option));
  options.push_back(
      integer("oversampling")
          .between(0, most_oversampling)
          .otherwise("0")
          .says("steps of the simulation per recorded sample; the sample is their mean, or sum for counts; 0: as many "
                "as the fastest motion needs"));
  return options;
}

std::vector<double> coefficients_of(const Model& model, const Output& output, const Settings& truth) {
  const auto physical = model.coefficients ? model.coefficients(truth) : std::map<std::string, double>{};
  std::vector<double> coefficients;
  for (const auto& term : output.terms) {
    const auto found = physical.find(term.name);
    coefficients.push_back(truth.has(term.name)      ? truth.number(term.name)
                           : found != physical.end() ? found->second
                                                     : 0.0);
  }
  return coefficients;
}

NoiseModel noise_of(const Settings& truth, const std::string& prefix) {
  const auto number = [&](const char* name) { return truth.number(prefix + name); };
  return {number("quantization_noise"), number("angle_random_walk"), number("bias_instability"),
          number("rate_random_walk"),   number("rate_ramp"),         number("markov_sd"),
          number("markov_time")};
}

const Model& find_model(std::string_view name) { return find_entry(model_catalogue(), name, "model"); }

}  // namespace tumble
