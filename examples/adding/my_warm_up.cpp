// A method of one's own that is not linear: the start-up transient of a fibre-optic gyro at rest, with its time constant.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/regression/mixed_model.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/error.hpp"

namespace tumble::my_warm_up {
namespace {

std::vector<Role> roles() { return {{"gyro", "deg/h", true, "output of the gyro, from power-on"}}; }

std::vector<Option> options() {
  return {quantity("settling", "s").at_least(0).otherwise("2 s").says("not used after the stand has settled"),
          quantity("averaging", "s").above(0).otherwise("10 s").says("length of a block of samples")};
}

/// y = w_x + D + E exp(-t/tau), with the time t since power-on.
struct Transient {
  double drift = 0.0;          ///< D [rad/s]
  double size = 0.0;           ///< E [rad/s]
  double time_constant = 1.0;  ///< tau [s]
};

/// A block of samples: what is observed.
struct Block {
  std::size_t stretch = 0;
  double time = 0.0;     ///< [s since power-on] middle
  double output = 0.0;   ///< [rad/s]
  double seconds = 0.0;  ///< [s] of the samples that are present
};

/// A block of the samples from `begin` on; without seconds where none of them is present.
Block block_of(const ConductedTest& test, std::size_t stretch, std::size_t begin, std::size_t count) {
  const Stretch& of = test.stretches[stretch];
  Block block{stretch};
  double present = 0.0;
  for (std::size_t i = begin; i < begin + count; ++i) {
    if (!std::isfinite(of.values[i])) continue;
    block.time += of.first + (static_cast<double>(i) + 0.5) * of.step;
    block.output += of.values[i];
    present += 1.0;
  }
  block.time /= present, block.output /= present;
  block.seconds = present * of.step;
  return block;
}

std::vector<Block> blocks_of(const ConductedTest& test, double averaging) {
  std::vector<Block> blocks;
  for (std::size_t s = 0; s < test.stretches.size(); ++s) {
    const auto count = static_cast<std::size_t>(std::max(1.0, std::round(averaging / test.stretches[s].step)));
    for (std::size_t begin = 0; begin + count <= test.stretches[s].samples; begin += count)
      if (const Block block = block_of(test, s, begin, count); block.seconds > 0.0) blocks.push_back(block);
  }
  constexpr std::size_t least = 8;  // three parameters, and some to judge the noise by
  if (blocks.size() < least)
    throw Error(Error::Kind::bad_data, say("only {} blocks of samples; 8 are needed", blocks.size()));
  const auto differs = [&](const Block& block) { return block.output != blocks.front().output; };
  if (std::ranges::none_of(blocks, differs))
    throw Error(Error::Kind::bad_data, "the output never changes: is the gyro connected?");
  return blocks;
}

/// The blocks as the generic tools see them: rows of one output, which see the rate along x.
Observation observation_of(const std::vector<Block>& blocks) {
  Observation rows;
  for (const Block& block : blocks) rows.stretch.push_back(block.stretch);
  rows.add = [&blocks](const Reference& reference, std::size_t stretch, Detail, OutputRows out) {
    std::size_t row = 0;
    for (const Block& block : blocks) {
      if (block.stretch != stretch) continue;
      Felt felt;
      reference.felt(block.time, 1.0, std::span(&felt, 1));
      out[0][row++] += felt.rate.x;
    }
  };
  return rows;
}

/// The input w_x [rad/s] of each block, by the rig without errors.
std::vector<double> inputs_of(const ConductedTest& test, const std::vector<Block>& blocks) {
  std::vector<double> inputs;
  for (const Block& block : blocks) {
    Felt felt;
    const Stretch& stretch = test.stretches[block.stretch];
    test.power_ups[stretch.power_up].reference.felt(block.time, 1.0, std::span(&felt, 1));
    inputs.push_back(felt.rate.x);
  }
  return inputs;
}

/// The model linearised at `at`: derivatives by D, E and tau, and what remains to be explained.
MixedData linearised(const std::vector<Block>& blocks, const std::vector<double>& inputs, const Transient& at) {
  MixedData data;
  data.design = Matrix(blocks.size(), 3);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const double x = blocks[i].time / at.time_constant, decay = std::exp(-x);
    data.design(i, 0) = 1.0;
    data.design(i, 1) = decay;
    data.design(i, 2) = at.size * decay * x / at.time_constant;
    data.observations.push_back(blocks[i].output - inputs[i] - at.drift - at.size * decay);
    data.weights.push_back(blocks[i].seconds);
    const bool begins = i > 0 && blocks[i].stretch != blocks[i - 1].stretch;
    data.segment.push_back((i > 0 ? data.segment.back() : 0) + (begins ? 1 : 0));
  }
  return data;
}

double squares(const MixedData& data) {
  double sum = 0.0;
  for (std::size_t i = 0; i < data.observations.size(); ++i)
    sum += data.weights[i] * data.observations[i] * data.observations[i];
  return sum;
}

/// The best of some time constants, each with the D and E that fit it: for a given tau the problem is linear.
Transient start_of(const std::vector<Block>& blocks, const std::vector<double>& inputs) {
  const double last = blocks.back().time;
  Transient best;
  double least = std::numeric_limits<double>::infinity();
  for (double tau = last / 100.0; tau < last; tau *= 1.3) {
    MixedData data = linearised(blocks, inputs, {.time_constant = tau});
    data.design.columns = 2;
    data.design.values.resize(2 * blocks.size());  // column after column: that of tau is the last
    const auto fit = least_squares(data.design, data.observations, data.weights, {.names = {"D", "E"}});
    const Transient at{fit.parameters[0], fit.parameters[1], tau};
    if (const double sum = squares(linearised(blocks, inputs, at)); sum < least) least = sum, best = at;
  }
  return best;
}

struct Solution {
  Transient at;
  MixedFit fit;                   ///< of the model linearised at the answer: its covariance is that of D, E and tau
  std::vector<double> residuals;  ///< [rad/s] of each block
};

/// Whether a step changes the answer by nothing that matters: 1e-6 of its uncertainty, or rounding.
bool is_small(const MixedFit& fit, const Transient& at) {
  const double values[]{at.drift, at.size, at.time_constant};
  for (std::size_t j = 0; j < 3; ++j)
    if (!(std::abs(fit.parameters[j]) <= 1e-6 * std::sqrt(fit.covariance(j, j)) + 1e-12 * std::abs(values[j])))
      return false;
  return true;
}

/// Gauss-Newton: each step is a linear fit with the errors of the rig and the noise of the record.
Solution solve(const ConductedTest& test, const std::vector<Block>& blocks) {
  const auto inputs = inputs_of(test, blocks);
  const auto effects = rig_effects(test, observation_of(blocks)).front();
  Transient at = start_of(blocks, inputs);
  for (int step = 0; step < 50 && at.time_constant > 0.0; ++step) {
    MixedData data = linearised(blocks, inputs, at);
    data.effects = effects;
    MixedFit fit = fit_mixed_model(data);
    if (is_small(fit, at)) return {at, std::move(fit), std::move(data.observations)};
    at.drift += fit.parameters[0];
    at.size += fit.parameters[1];
    at.time_constant += fit.parameters[2];
  }
  throw Error(Error::Kind::bad_data, "no time constant fits: record the gyro from power-on until it no longer drifts");
}

/// What the recording must show: a transient that is larger than its uncertainty.
void require_transient(const Solution& solution) {
  if (std::abs(solution.at.size) > 4.0 * std::sqrt(solution.fit.covariance(1, 1))) return;
  throw Error(Error::Kind::bad_data, "the recording shows no start-up transient: its time constant is not known");
}

/// How the output errs, in the terms of the model that simulates the gyro, with the time constant that was found.
OutputModel model_of(const Estimate& estimate, const Transient& at, const std::vector<Block>& blocks) {
  Settings constants = defaults(find_model("fiber_optic_gyro").constants());
  constants.set_number("startup_time", at.time_constant, Unit::parse("s"));
  std::vector<Felt> felt;
  for (const Block& block : blocks) felt.push_back({.since_power_on = block.time});
  const auto terms = linear::terms_of("fiber_optic_gyro", constants, {"bias_0", "startup_transient"});
  OutputModel model = output_model(estimate, "gyro", Input::rate_x, "deg/h", ranges_over(terms, felt));
  // A term carries no uncertainty of tau: E t/tau^2 exp(-t/tau), which is greatest at t = tau, times that of tau.
  model.misfit = standard_uncertainty(estimate, 2) * std::abs(at.size) / (at.time_constant * std::numbers::e);
  return model;
}

Curve residuals_of(const Solution& solution, const std::vector<Block>& blocks) {
  Curve curve{
      "blocks", "residuals", {"time since power-on", Unit::parse("min"), {}}, {"residual", Unit::parse("deg/h"), {}}};
  curve.points = true;
  curve.y.values = solution.residuals;
  for (const Block& block : blocks) curve.x.values.push_back(block.time);
  return curve;
}

Estimate answer(const Solution& solution, const std::vector<Block>& blocks) {
  const auto& [at, fit, residuals] = solution;
  const Unit rate = Unit::parse("deg/h"), seconds = Unit::parse("s");
  Estimate estimate;
  estimate.parameters = {
      {"bias_0", "D", rate, at.drift, "constant drift", degrees_of_freedom(fit, {1, 0, 0})},
      {"startup_transient", "E", rate, at.size, "transient at power-on", degrees_of_freedom(fit, {0, 1, 0})},
      {"startup_time", "tau", seconds, at.time_constant, "time constant", degrees_of_freedom(fit, {0, 0, 1})}};
  settle(estimate, lines_of(fit.sources));
  estimate.fit = {blocks.size(), fit.degrees_of_freedom, fit.chi_square, fit.condition};
  estimate.curves = {residuals_of(solution, blocks)};
  estimate.models = {model_of(estimate, at, blocks)};
  return estimate;
}

Estimate identify(const Evidence& evidence, const Progress&) {
  const Settings& settings = evidence.plan.settings;
  const ConductedTest test =
      stretches(evidence, {.role = "gyro", .settling = settings.number("settling"), .needs_site = true});
  const auto blocks = blocks_of(test, settings.number("averaging"));
  const Solution solution = solve(test, blocks);
  require_transient(solution);
  return finished(answer(solution, blocks), test.findings);
}

}  // namespace

extern const Method my_warm_up{
    .name = "my_warm_up",
    .summary = "start-up transient of a gyro at rest: constant drift, size and time constant",
    .source = "least squares by Gauss and Newton",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .compensates = true};

}  // namespace tumble::my_warm_up
