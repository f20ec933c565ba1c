#include "tumble/reduce/linear/testing/table_trial.hpp"

#include <fmt/format.h>

#include "tumble/units/unit.hpp"

namespace tumble::linear {
namespace {

Motion hold(double degrees) { return {.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; }
Motion rate(double degrees) { return {.kind = Motion::Kind::rate, .value = si(degrees, "deg/s")}; }

void add(Plan& plan, const std::string& label, double duration, const Motion& outer, const Motion& inner) {
  plan.schedule.push_back({label, duration, 1, {{"outer", outer}, {"inner", inner}}});
}

}  // namespace

void add_table_motions(Plan& plan, double fastest, double amplitude, double frequency) {
  const Motion sine{.kind = Motion::Kind::sine, .amplitude = si(amplitude, "deg"), .frequency = frequency};
  const double faces[][2] = {{0, 0}, {90, 0}, {90, 90}, {90, 180}, {90, 270}, {180, 0}};
  for (const auto& face : faces)
    add(plan, fmt::format("rest {:g} {:g}", face[0], face[1]), 20.0, hold(face[0]), hold(face[1]));
  for (const double speed : {fastest, -fastest, 0.5 * fastest, -0.5 * fastest}) {
    for (const double turn : {0.0, 45.0, 90.0})
      add(plan, fmt::format("outer {:g} at {:g}", speed, turn), 16.0, rate(speed), hold(turn));
    for (const double tilt : {0.0, 90.0})
      add(plan, fmt::format("inner {:g} at {:g}", speed, tilt), 16.0, hold(tilt), rate(speed));
    add(plan, fmt::format("both {:g}", speed), 24.0, rate(speed), rate(0.75 * speed));
    add(plan, fmt::format("against {:g}", speed), 24.0, rate(speed), rate(-0.75 * speed));
  }
  for (const double turn : {0.0, 45.0, 90.0}) {
    add(plan, fmt::format("to sine {:g}", turn), 10.0, hold(0.0), hold(turn));
    add(plan, fmt::format("outer sine {:g}", turn), 20.0, sine, hold(turn));
  }
  add(plan, "to inner sine", 10.0, hold(45.0), hold(0.0));
  add(plan, "inner sine", 20.0, hold(45.0), sine);
  add(plan, "end", 10.0, hold(0.0), hold(0.0));
}

}  // namespace tumble::linear
