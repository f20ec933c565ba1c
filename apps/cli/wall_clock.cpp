#include "wall_clock.hpp"

#include <chrono>

#include "tumble/units/error.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::cli {

double wall_time() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double speed_of(const std::string& text) {
  const double speed = parse_si(text, Unit::parse("1"));
  if (speed > 0.0 && speed <= 1000.0) return speed;
  throw Error(Error::Kind::bad_input, say("--speed {}: a number above 0, up to 1000, is expected", Name{text}));
}

}  // namespace tumble::cli
