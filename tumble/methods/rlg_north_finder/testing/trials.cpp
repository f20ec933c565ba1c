#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>
#include <utility>

#include "tumble/math/random.hpp"
#include "tumble/methods/rlg_north_finder/outputs.hpp"
#include "tumble/methods/rlg_north_finder/testing/trial.hpp"
#include "tumble/models/model.hpp"
#include "tumble/models/sagnac.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::rlg_north_finder {
namespace {

using Kind = Motion::Kind;
constexpr double speed = 20.0, acceleration = 2.0;  ///< [deg/s], [deg/s^2]: ten seconds to speed up

Motion hold(double degrees) { return {.kind = Kind::hold, .value = si(degrees, "deg")}; }

Beside accelerometer(const char* name, double yaw, double bias, double along_p, double along_o, double scale_error) {
  const Model& model = find_model("pendulous_accelerometer");
  Beside beside{name, model.name, defaults(truth_options(model))};
  beside.mount_yaw = si(yaw, "deg");
  beside.truth.set_word("output", "count");
  beside.truth.set_number("pulse_scale_factor", si(100000.0, "pulse/s/g"), Unit::parse("pulse/s/g"));
  beside.truth.set_number("bias", si(bias, "ug"), Unit::parse("ug"));
  beside.truth.set_number("scale_factor_error", si(scale_error, "ppm"), Unit::parse("ppm"));
  beside.truth.set_number("misalignment_o", si(along_p, "arcsec"), Unit::parse("arcsec"));
  beside.truth.set_number("misalignment_p", si(along_o, "arcsec"), Unit::parse("arcsec"));
  beside.truth.set_number("angle_random_walk", si(20.0, "ug/sqrt(Hz)"), Unit::parse("ug/sqrt(Hz)"));
  beside.truth.set_number("bias_instability", si(3.0, "ug"), Unit::parse("ug"));
  return beside;
}

}  // namespace

Schedule path(double stay, int turns) {
  Schedule schedule;
  const auto rest = [&](const char* label, double outer, double inner) {
    schedule.push_back({label, stay, 1, {{"outer", hold(outer)}, {"inner", hold(inner)}}});
  };
  const double angle = 360.0 * turns;
  const auto rotation = [&](const char* about, const char* axis, double from) {
    // to speed up and slow down takes as long as one of them at full speed; then five seconds at rest
    const double seconds = std::ceil(angle / speed + speed / acceleration) + 5.0;
    for (const bool forward : {true, false}) {
      const Motion turn{
          .kind = Kind::slew, .value = si(speed, "deg/s"), .to = si(forward ? from + angle : from, "deg")};
      schedule.push_back(
          {fmt::format("about {}, {}", about, forward ? "forward" : "reverse"), seconds, 1, {{axis, turn}}});
    }
  };
  rest("1", 0, 0);
  rest("2", -90, 0);
  rest("3", -90, 90);
  rest("4", -90, 180);
  rest("5", -90, 270);
  rest("6", 0, 360);
  rotation("z", "inner", 360);
  rest("7", 180, 0);
  rotation("y", "outer", 180);
  rest("8", 180, 90);
  rotation("x", "outer", 180);
  schedule.front().axes["mount_yaw"] = hold(-90);
  return schedule;
}

Plan trial_plan(double stay, int turns) {
  Plan plan = trial_plan("rlg_north_finder", options(), "ring_laser_gyro", "two_axis_table", 1.0);
  plan.rig.set_number("outer_azimuth", si(53.0 - 90.0, "deg"), Unit::parse("deg"));
  for (const char* axis : {"outer", "inner"}) {
    plan.rig.set_number(std::string(axis) + "_max_rate", si(speed, "deg/s"), Unit::parse("deg/s"));
    plan.rig.set_number(std::string(axis) + "_max_acceleration", si(acceleration, "deg/s^2"), Unit::parse("deg/s^2"));
  }
  plan.rig.set_number("mount_sd", 0.0, Unit::parse("arcsec"));  // the axes of the table are those of the body
  set_truth(plan, "bias", 0.8, "deg/h");
  set_truth(plan, "misalignment_y", 60.0, "arcsec");
  set_truth(plan, "misalignment_z", -110.0, "arcsec");
  set_truth(plan, "scale_factor_error", 40.0, "ppm");
  set_truth(plan, "angle_random_walk", 0.01, "deg/sqrt(h)");
  set_truth(plan, "bias_instability", 0.05, "deg/h");
  set_setting(plan, "gyro_bias_instability", 0.05, "deg/h");
  set_setting(plan, "accelerometer_bias_instability", 3.0, "ug");
  plan.truth.set_integer("edges", 4);
  plan.beside.push_back(accelerometer("x", 0.0, 120.0, 80.0, 50.0, 300.0));
  plan.beside.push_back(accelerometer("y", 90.0, -260.0, -35.0, 90.0, -200.0));
  plan.channels = {{"accelerometer_x", {{"x.accelerometer", {}}}}, {"accelerometer_y", {{"y.accelerometer", {}}}}};
  plan.schedule = path(stay, turns);
  return plan;
}

std::vector<double> truth_of(const Plan& plan) {
  const Settings& truth = plan.truth;
  std::vector<double> out;
  const auto append = [&](double k, double own, double bias, double first, double second) {
    for (const double v : {k * own, bias / own, first / own, second / own}) out.push_back(v);
  };
  append(ring_laser_scale_factor(truth) * truth.integer("edges"), 1.0 + truth.number("scale_factor_error"),
         truth.number("bias"), truth.number("misalignment_y"), truth.number("misalignment_z"));
  for (std::size_t i = 0; i < 2; ++i) {
    const Settings& own = plan.beside[i].truth;
    // axes i, p, o are x, y, z of the first and y, -x, z of the second; the term of misalignment_p is -f_o
    const double p = (i == 0 ? 1.0 : -1.0) * own.number("misalignment_o");
    append(own.number("pulse_scale_factor"), 1.0 + own.number("scale_factor_error"), own.number("bias"), p,
           -own.number("misalignment_p"));
  }
  return out;
}

namespace {

Trial trial_of(Plan commanded, const Plan& carried_out, std::uint64_t seed) {
  Trial trial;
  trial.evidence.plan = std::move(commanded);
  trial.evidence.recordings.push_back(simulate(carried_out, seed, {}));
  const auto truth = truth_of(trial.evidence.plan);
  for (std::size_t p = 0; p < truth.size(); ++p) trial.truth.emplace_back(wanted()[p].name, truth[p]);
  return trial;
}

void reverse_signs(Settings& truth, std::initializer_list<std::pair<const char*, const char*>> names) {
  for (const auto& [name, unit] : names) truth.set_number(name, -truth.number(name), Unit::parse(unit));
}

/// The angles at which a hand leaves the axes that it turns.
void set_by_hand(const RandomStream& hand, Plan& plan) {
  std::uint64_t draw = 0;
  for (auto& segment : plan.schedule)
    for (auto& [axis, motion] : segment.axes) {
      if (axis == "mount_yaw") continue;
      (motion.kind == Kind::hold ? motion.value : motion.to) += si(0.3, "deg") * hand.normal(draw++);
    }
}

/// One sample in a hundred of the stays is lost. A total of counts needs every sample.
void lose_samples(const Plan& plan, const RandomStream& random, Recording& recording) {
  for (Channel& channel : recording.channels) {
    const RandomStream lost = random.split(channel.name);
    double begin = 0.0;
    for (const auto& segment : plan.schedule) {
      const bool stay = !segment.label.starts_with("about");
      for (std::size_t i = index_at(channel, begin + 1.0); stay && channel.time(i) < begin + segment.duration - 1.0;
           ++i)
        if (lost.uniform(i) < 0.01) channel.values[i] = std::nan("");
      begin += segment.duration;
    }
  }
}

}  // namespace

Trial trial(std::uint64_t seed) {
  const Plan plan = trial_plan(60.0, 2);
  return trial_of(plan, plan, seed);
}

Trial second_trial(std::uint64_t seed) {
  Plan plan = trial_plan(80.0, 3);
  plan.site = Site{.latitude = si(-45.9, "deg"), .height = 30.0, .gravity = {}, .latitude_sd = si(100.0, "arcsec")};
  plan.rig.set_number("outer_azimuth", si(20.0, "deg"), Unit::parse("deg"));
  reverse_signs(
      plan.truth,
      {{"bias", "deg/h"}, {"misalignment_y", "arcsec"}, {"misalignment_z", "arcsec"}, {"scale_factor_error", "ppm"}});
  for (auto& one : plan.beside)
    reverse_signs(
        one.truth,
        {{"bias", "ug"}, {"misalignment_o", "arcsec"}, {"misalignment_p", "arcsec"}, {"scale_factor_error", "ppm"}});
  Plan by_hand = plan;
  set_by_hand(RandomStream(seed).split("hand"), by_hand);
  Trial trial = trial_of(std::move(plan), by_hand, seed);
  lose_samples(by_hand, RandomStream(seed).split("lost"), trial.evidence.recordings[0]);
  return trial;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::rlg_north_finder
