#include "tumble/reduce/accelerometer/output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/clocks/clock.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer {
namespace {

/// Windows of a count in a second, without the pauses of the recording.
double windows_per_second(const Channel& channel) {
  if (channel.timeline.uniform()) return channel.timeline.rate;
  const double rate = clock_of(channel).rate;
  return rate > 0.0 ? rate : mean_rate(channel);
}

}  // namespace

std::vector<Role> roles() {
  return {{"accelerometer", "", true, "output: a specific force, a current, a voltage, or pulses in each sample"}};
}

Output output_of(const Channel& channel) {
  const auto is = [&](const char* unit) { return channel.unit.dimension() == Unit::parse(unit).dimension(); };
  if (is("g")) return {};
  if (is("mA")) return {Unit::parse("mA/g")};
  if (is("V")) return {Unit::parse("V/g")};
  if (is("pulse")) return {Unit::parse("pulse/s/g"), windows_per_second(channel), true};
  throw Error(Error::Kind::bad_data, say("channel '{}' is in {}: the accelerometer's output must be a "
                                         "specific force (g), mA, V or pulses",
                                         channel.name, Name{channel.unit.text()}));
}

Output output_of(const Settings& truth, double sample_rate) {
  const auto& word = truth.word("output");
  if (word == "current") return {Unit::parse("mA/g")};
  if (word == "voltage") return {Unit::parse("V/g")};
  if (word == "count") return {Unit::parse("pulse/s/g"), sample_rate, true};
  return {};
}

double scale_factor_of(const Settings& truth) {
  const auto& word = truth.word("output");
  if (word == "specific_force") return 1.0;
  const std::string name = (word == "count" ? "pulse" : word) + "_scale_factor";
  const double scale = truth.has(name) ? truth.number(name) : 0.0;
  if (scale == 0.0)
    throw Error(Error::Kind::bad_input, say("[truth] output = \"{}\" needs {}, not zero", word, Name{name}));
  return scale;
}

std::vector<Term> terms_of(const std::vector<std::string>& names) {
  const char* model = "pendulous_accelerometer";
  return linear::terms_of(model, defaults(find_model(model).constants()), names);
}

Option scale_factor_option(const std::string& description) { return text("scale_factor").says(description); }

std::optional<double> given_scale_factor(const Settings& settings, const Output& output) {
  if (!settings.has("scale_factor") || settings.word("scale_factor").empty()) return std::nullopt;
  double scale = 0.0;
  try {
    scale = parse_si(settings.word("scale_factor"), output.scale_factor);
  } catch (const Error& error) {
    throw Error(Error::Kind::bad_input, say("[settings] scale_factor: {}", reason_of(error)));
  }
  if (!(std::abs(scale) > 0.0) || !std::isfinite(scale))
    throw Error(Error::Kind::bad_input, "[settings] scale_factor must not be zero");
  return scale;
}

void set_model(const Evidence& evidence, const linear::Solution& solution, const std::vector<std::string>& names,
               Estimate& estimate) {
  TermRanges ranges;
  for (const Term& term : terms_of(names)) {
    const auto column = std::ranges::find(solution.columns, term.name, &Term::name);
    if (column == solution.columns.end()) continue;
    const auto j = static_cast<std::size_t>(column - solution.columns.begin());
    ranges.terms.push_back(term);
    ranges.least.push_back(solution.least[j]);
    ranges.greatest.push_back(solution.greatest[j]);
  }
  OutputModel model = output_model(estimate, "accelerometer", Input::specific_force_x, "g", ranges);
  set_scale(estimate, "scale_factor", model);
  if (!model.scale && !evidence.recordings.empty()) {
    const Channel& channel = require_channel(evidence, evidence.recordings.front(), "accelerometer");
    set_reading(channel, scale_of(evidence.plan.settings, channel), model);
  }
  if (const auto own = std::ranges::find(solution.columns, std::string("scale_factor_error"), &Term::name);
      own != solution.columns.end()) {
    const auto j = static_cast<std::size_t>(own - solution.columns.begin());
    model.covered = {{{{Input::specific_force_x, 1.0}}, solution.least[j], solution.greatest[j]}};
  }
  estimate.models = {std::move(model)};
}

double required_scale_factor(const Settings& settings, const Channel& channel) {
  const Output output = output_of(channel);
  if (output.scale_factor == Unit()) return 1.0;
  const auto scale = given_scale_factor(settings, output);
  if (!scale)
    throw Error(Error::Kind::bad_input, say("channel '{}' is in {}: [settings] scale_factor must say how many "
                                            "{} it gives",
                                            channel.name, Name{channel.unit.text()}, Name{output.scale_factor.text()}));
  return *scale;
}

double scale_of(const Settings& settings, const Channel& channel) {
  return output_of(channel).per_second / required_scale_factor(settings, channel);
}

}  // namespace tumble::accelerometer
