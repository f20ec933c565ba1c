#include "tumble/reduce/vibration/vibration.hpp"

namespace tumble::vibration {

std::vector<Option> options() {
  return {
      text("scale_factor")
          .says("K_1 of all units, \"20000 pulse/s/g\", or of each, \"S1: 20000 pulse/s/g, S2: 19990 pulse/s/g\"; "
                "absent: from the segments at rest, where gravity along the input axis is known"),
      quantity("scale_factor_sd", "%")
          .at_least(0)
          .otherwise("0.1 %")
          .says("standard uncertainty of a scale_factor that is given"),
      quantity("bias_sd", "mg")
          .at_least(0)
          .otherwise("5 mg")
          .says("size of the units' bias: divided by gravity, it is the uncertainty of a scale factor from rest"),
      quantity("settling", "s")
          .at_least(0)
          .otherwise("0.5 s")
          .says("time to skip where a segment begins; at least two cycles are skipped"),
      word("windows", {"auto", "even", "stamps"})
          .otherwise("auto")
          .says("counting windows where stamps scatter: all equal, or each from its stamp to the next; auto: whichever "
                "the counts at rest follow"),
      word("samples", {"window", "instant"})
          .otherwise("window")
          .says("meaning of a sample of a unit that does not count: its mean from stamp to stamp, or its value at the "
                "stamp"),
      word("reference_is", {"instant", "window"})
          .otherwise("instant")
          .says(
              "meaning of a sample of a reference that is sampled with the windows: its value in their middle, or its "
              "mean over them"),
      quantity("reference_gain_sd", "%")
          .at_least(0)
          .otherwise("0.5 %")
          .says("standard uncertainty of the reference's scale"),
      quantity("cross_coupling", "ug/g^2")
          .at_least(0)
          .otherwise("20 ug/g^2")
          .says("size of K_ip and K_io, which rectify motion across the input axis"),
      quantity("range", "g").above(0).says("greatest specific force that the units show, of either sign"),
  };
}

}  // namespace tumble::vibration
