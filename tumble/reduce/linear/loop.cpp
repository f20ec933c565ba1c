#include "tumble/reduce/linear/linear.hpp"

namespace tumble::linear {

std::vector<Option> loop_options() {
  return {quantity("natural_frequency", "Hz")
              .above(0)
              .says("natural frequency of the rebalance loop: input and regressors pass through it, so that its lag is "
                    "no error term; absent: no loop"),
          quantity("damping_ratio").above(0).otherwise("0.7").says("damping ratio of the rebalance loop"),
          quantity("loop_lag_sd", "%")
              .at_least(0)
              .otherwise("1 %")
              .says("relative standard uncertainty of the lag 2 zeta/w_n of the rebalance loop")};
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
  const auto loop = [&](double f) { return loop_of(find_model(model), f, damping); };
  problem.response = loop(frequency);
  if (sd > 0.0) problem.response_errors.push_back({"lag of the loop", loop(frequency / (1.0 + sd))});
}

}  // namespace tumble::linear
