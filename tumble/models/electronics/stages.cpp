#include "tumble/models/electronics/stages.hpp"

#include <cmath>

#include "tumble/models/given/given.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::electronics {
namespace {

using namespace given;

/// Whatever is out of bounds among the options of this file.
void refuse_unusable(const Settings& truth) {
  std::vector<std::string> problems;
  given::require_positive(
      truth, {"natural_frequency", "damping_ratio", "time_constant", "range", "range_negative", "resolution"},
      problems);
  if (truth.has("time_constant") && truth.has("natural_frequency"))
    problems.push_back("give time_constant (first-order loop) or natural_frequency (second-order), not both");
  if (truth.has("dead_zone") && truth.number("dead_zone") < 0.0) problems.push_back("dead_zone must not be negative");
  if (truth.has("range_negative") && !truth.has("range")) problems.push_back("range_negative needs range as well");
  given::refuse(std::move(problems));
}

}  // namespace

std::vector<Option> loop_options() {
  using Type = Option::Type;
  return {{"natural_frequency",
           Type::quantity,
           "Hz",
           "",
           {},
           "natural frequency of the loop that holds the pick-off at null; default: no lag"},
          {"damping_ratio", Type::quantity, "1", "0.7", {}, "damping ratio of that loop"}};
}

Response loop(const Settings& truth, double step) {
  refuse_unusable(truth);
  if (truth.has("time_constant")) return first_order_loop(truth.number("time_constant"), step);
  if (!truth.has("natural_frequency")) return nullptr;
  return second_order_loop(truth.number("natural_frequency"), truth.number("damping_ratio"), step);
}

Response balanced(double inertia, double damping, double stiffness, double step) {
  if (!(stiffness > 0.0 && inertia > 0.0 && damping > 0.0)) return nullptr;
  return second_order_loop(std::sqrt(stiffness / inertia) / two_pi, damping / (2.0 * std::sqrt(stiffness * inertia)),
                           step);
}

std::vector<Option> limit_options(const std::string& unit) {
  using Type = Option::Type;
  return {{"range", Type::quantity, unit, "", {}, "largest output; default: no limit"},
          {"range_negative", Type::quantity, unit, "", {}, "largest negative output, as a magnitude (default: range)"},
          {"dead_zone", Type::quantity, unit, "", {}, "outputs up to this magnitude are recorded as zero"},
          {"resolution", Type::quantity, unit, "", {}, "the output is rounded to whole multiples of this"}};
}

Response limits(const Settings& truth) {
  refuse_unusable(truth);
  std::vector<Response> stages;
  if (truth.has("range"))
    stages.push_back(
        clip(-truth.number(truth.has("range_negative") ? "range_negative" : "range"), truth.number("range")));
  if (truth.has("dead_zone")) stages.push_back(dead_zone(-truth.number("dead_zone"), truth.number("dead_zone")));
  if (truth.has("resolution")) stages.push_back(quantiser(truth.number("resolution")));
  return in_series(std::move(stages));
}

}  // namespace tumble::electronics
