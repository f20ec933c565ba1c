#include "tumble/models/testing/truth.hpp"

#include "tumble/units/error.hpp"

namespace tumble::testing {

Settings truth_of(const Model& model, const std::vector<std::pair<std::string, std::string>>& written) {
  std::vector<Given> given;
  for (const auto& [key, text] : written) given.push_back({key, text, "test", true, false});
  Problems problems;
  auto truth = resolve(truth_options(model), given, model.name, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return truth;
}

double indicated(const Model& model, const Settings& truth, const Felt& felt, std::size_t output) {
  const auto outputs = model.outputs(truth);
  const auto& of = outputs.at(output);
  const auto coefficients = coefficients_of(model, of, truth);
  double sum = of.input ? of.input(felt) : 0.0;
  for (std::size_t t = 0; t < of.terms.size(); ++t) sum += coefficients[t] * of.terms[t].regressor(felt);
  return sum;
}

std::size_t problems_of(const Model& model, const Settings& truth) {
  try {
    model.coefficients(truth);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_input) throw;
    return error.problems.size();
  }
  return 0;
}

Vector3 any(const RandomStream& random, std::uint64_t number, double largest) {
  const auto component = [&](std::uint64_t k) { return largest * (2.0 * random.uniform(3 * number + k) - 1.0); };
  return {component(0), component(1), component(2)};
}

}  // namespace tumble::testing
