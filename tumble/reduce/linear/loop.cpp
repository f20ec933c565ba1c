#include "tumble/reduce/linear/linear.hpp"
#include "tumble/units/error.hpp"

namespace tumble::linear {

std::vector<Option> loop_options() {
  using Type = Option::Type;
  return {{"natural_frequency",
           Type::quantity,
           "Hz",
           "",
           {},
           "of the rebalance loop; given: input and regressors pass through it, so that its lag is no error term"},
          {"damping_ratio", Type::quantity, "1", "0.7", {}, "of the rebalance loop"},
          {"loop_lag_sd", Type::quantity, "%", "1 %", {}, "relative standard uncertainty of the lag 2 zeta/w_n"}};
}

namespace {

/// The loop alone, as the model itself records through it.
std::function<Response(double)> loop_of(const Model& model, double frequency, double damping) {
  Settings truth = defaults(truth_options(model));
  truth.set_number("natural_frequency", frequency, Unit::parse("Hz"));
  truth.set_number("damping_ratio", damping, Unit());
  return [&model, truth](double step) { return model.record(truth, 0, step, RandomStream(0)).response; };
}

}  // namespace

void set_loop(const Settings& settings, const std::string& model, Problem& problem) {
  if (!settings.has("natural_frequency")) return;
  const double frequency = settings.number("natural_frequency"), damping = settings.number("damping_ratio");
  const double sd = settings.number("loop_lag_sd");
  if (!(frequency > 0.0) || !(damping > 0.0) || sd < 0.0)
    throw Error(Error::Kind::bad_input,
                "[settings] natural_frequency and damping_ratio must be above zero, loop_lag_sd not below");
  const auto loop = [&](double f) { return loop_of(find_model(model), f, damping); };
  problem.response = loop(frequency);
  if (sd > 0.0) problem.response_errors.push_back({"lag of the loop", loop(frequency / (1.0 + sd))});
}

}  // namespace tumble::linear
