#pragma once

#include <string>

#include "tumble/core/evidence.hpp"

/// Which unit a result is of, and what a recording says of it (decision 126).
namespace tumble {

/// Keys of --set: the serial number of the unit, and the slot of the station in which it was tested.
inline constexpr const char *serial_key = "instrument.serial", *slot_key = "instrument.slot";

/// A unit, and what is to be said of how it is known.
struct UnitIdentity {
  std::string serial;  ///< empty: nobody says it
  Findings findings;
};

/// A recording goes before the plan of a test, which is often written for several units.
///
/// Throws    Error::bad_input where a recording contradicts the serial number or the slot of the command line;
///           Error::bad_data where recordings of one plan are of different units
UnitIdentity unit_of(const Evidence& evidence);

}  // namespace tumble
