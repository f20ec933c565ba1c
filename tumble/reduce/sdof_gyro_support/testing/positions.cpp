#include "tumble/reduce/sdof_gyro_support/testing/positions.hpp"

#include "tumble/reduce/testing/trial_plan.hpp"

namespace tumble::sdof_gyro_support {

Plan trial_plan(const std::string& method, const std::vector<Option>& options, const std::string& rig, double rate) {
  Plan plan = trial_plan(method, options, "sdof_gyro", rig, rate);
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  const char* first = "deg/h/g";
  const char* second = "deg/h/g^2";
  set("D_F", 1.8, "deg/h");
  set("D_I", 2.5, first);
  set("D_O", 0.01, first);
  set("D_S", -1.2, first);
  set("D_IO", 0.03, second);
  set("D_OS", -0.02, second);
  set("D_IS", 0.08, second);
  set("D_II", 0.05, second);
  set("D_SS", -0.04, second);
  set("angle_random_walk", 0.002, "deg/sqrt(h)");
  set("bias_instability", 0.01, "deg/h");
  return plan;
}

std::vector<Position> cube_positions() {
  const auto degrees = [](const char* label, double outer, double inner) {
    return Position{label, si(outer, "deg"), si(inner, "deg")};
  };
  // f = (sin outer sin inner, sin outer cos inner, cos outer) g in the axes I, O, S.
  const double corner = 54.735610317245346;
  return {degrees("I up", 90, 90),
          degrees("O S", 45, 0),
          degrees("-O", 90, 180),
          degrees("I O -S", 180 - corner, 45),
          degrees("-I S", 45, 270),
          degrees("S up", 0, 0),
          degrees("I -O", 90, 135),
          degrees("-O -S", 135, 180),
          degrees("-I -O S", corner, 225),
          degrees("O up", 90, 0),
          degrees("I S", 45, 90),
          degrees("-I -S", 135, 270),
          degrees("-I O S", corner, 315),
          degrees("-I down", 90, 270),
          degrees("I O", 90, 45),
          degrees("-O S", 45, 180),
          degrees("I -O -S", 180 - corner, 135),
          degrees("S down", 180, 0),
          degrees("-I O", 90, 315),
          degrees("I -S", 135, 90),
          degrees("I O S", corner, 45),
          degrees("-I -O", 90, 225),
          degrees("O -S", 135, 0),
          degrees("-I O -S", 180 - corner, 315),
          degrees("I -O S", corner, 135),
          degrees("-I -O -S", 180 - corner, 225)};
}

Segment at(const Position& position, double duration) {
  return {position.label,
          duration,
          1,
          {{"outer", {.kind = Motion::Kind::hold, .value = position.outer}},
           {"inner", {.kind = Motion::Kind::hold, .value = position.inner}}}};
}

}  // namespace tumble::sdof_gyro_support
