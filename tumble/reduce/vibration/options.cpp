#include "tumble/reduce/vibration/vibration.hpp"

namespace tumble::vibration {

std::vector<Option> options() {
  using Type = Option::Type;
  return {
      {"scale_factor",
       Type::text,
       "1",
       "",
       {},
       "K_1 of all units, \"20000 pulse/s/g\", or of each, \"S1: 20000 pulse/s/g, S2: 19990 pulse/s/g\"; absent: from "
       "the segments at rest, where gravity along the input axis is known"},
      {"scale_factor_sd", Type::quantity, "%", "0.1 %", {}, "standard uncertainty of a scale_factor that is given"},
      {"bias_sd",
       Type::quantity,
       "mg",
       "5 mg",
       {},
       "size of the units' bias: what a scale factor found at rest is uncertain by, over gravity"},
      {"settling", Type::quantity, "s", "0.5 s", {}, "left out where a segment begins; two cycles at least"},
      {"windows",
       Type::word,
       "1",
       "auto",
       {"auto", "even", "stamps"},
       "counting windows where stamps scatter: all alike, or each from its stamp to the next; auto: as the counts at "
       "rest say"},
      {"samples",
       Type::word,
       "1",
       "window",
       {"window", "instant"},
       "a sample of a unit that does not count is its mean from stamp to stamp, or its value at the stamp"},
      {"reference_is",
       Type::word,
       "1",
       "instant",
       {"instant", "window"},
       "the reference, sampled with the windows, is read in their middle or is its mean over them"},
      {"reference_gain_sd", Type::quantity, "%", "0.5 %", {}, "standard uncertainty of the reference's scale"},
      {"range", Type::quantity, "g", "", {}, "greatest specific force that the units show, of either sign"},
  };
}

}  // namespace tumble::vibration
