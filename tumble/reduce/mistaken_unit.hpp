#pragma once

#include <optional>

namespace tumble {

/// A unit in which data of another unit are read, by the output for an input of one.
struct MistakenUnit {
  double ratio = 1.0;  ///< [1]
  const char *of, *read_as;
};

/// The mistake that a gain of an output [1] shows: deg/s read as rad/s, g read as m/s^2, thousandths. Within 15 %, which
/// leaves room for the scale factor of the instrument. A gain of 0.5 to 2 shows no mistake.
std::optional<MistakenUnit> mistaken_unit_of_rate(double gain);
std::optional<MistakenUnit> mistaken_unit_of_force(double gain);

}  // namespace tumble
