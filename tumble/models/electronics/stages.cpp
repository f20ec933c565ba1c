#include "tumble/models/electronics/stages.hpp"

#include <cmath>

#include "tumble/models/given/given.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::electronics {
namespace {

using namespace given;

/// Options of this file that exclude or need each other.
void refuse_unusable(const Settings& truth) {
  Problems problems;
  if (truth.has("time_constant") && truth.has("natural_frequency"))
    problems.push_back("give time_constant (first-order loop) or natural_frequency (second-order), not both");
  if (truth.has("range_negative") && !truth.has("range")) problems.push_back("range_negative needs range as well");
  given::refuse(std::move(problems));
}

}  // namespace

std::vector<Option> loop_options() {
  return {quantity("natural_frequency", "Hz")
              .above(0)
              .says("natural frequency of the loop that holds the pick-off at null; default: no lag"),
          quantity("damping_ratio").above(0).otherwise("0.7").says("damping ratio of that loop")};
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
  return {quantity("range", unit).above(0).says("largest output; default: no limit"),
          quantity("range_negative", unit).above(0).says("largest negative output, as a magnitude (default: range)"),
          quantity("dead_zone", unit).at_least(0).says("outputs up to this magnitude are recorded as zero"),
          quantity("resolution", unit).above(0).says("the output is rounded to whole multiples of this")};
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
