#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "tumble/earth/earth.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/rlg_north_finder/outputs.hpp"
#include "tumble/methods/rlg_north_finder/testing/trial.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::rlg_north_finder {
namespace {

using Type = Motion::Kind;
constexpr double arcsec = std::numbers::pi / 648000.0;

const Method& method() { return find_method("rlg_north_finder"); }

/// A table without errors, counters that do not round, an instrument without noise.
Plan perfect(double stay = 300.0, int turns = 10) {
  Plan plan = trial_plan(stay, turns);
  plan.rig.set_flag("ideal", true);
  plan.truth.set_number("angle_random_walk", 0.0, Unit());
  for (auto& one : plan.beside) one.truth.set_number("angle_random_walk", 0.0, Unit());
  return plan;
}

/// Errors of the rig to be put in, by name.
using RigErrors = std::map<std::string, double>;

/// What counters that resolve any fraction of a pulse would show: the mean of the models over each sample, from 40
/// instants in it, with the table's errors as given.
Evidence unrounded(const Plan& plan, const RigErrors& given = {}, double second_order = 0.0) {
  const Rig& rig = find_rig(plan.rig_kind);
  const auto errors = rig.errors(plan.rig, plan.site);
  RigRun run{plan.schedule, plan.rig, plan.site, plan.sample_rate};
  run.errors = Matrix(errors.size(), plan.schedule.size());
  for (std::size_t e = 0; e < errors.size(); ++e)
    for (std::size_t s = 0; s < plan.schedule.size(); ++s)
      if (given.contains(errors[e].name)) run.errors(e, s) = given.at(errors[e].name);
  const Reference reference = rig.reference(run);
  const auto t = truth_of(plan);
  Recording recording;
  double end = 0.0;
  for (const auto& segment : plan.schedule) {
    recording.marks.push_back({segment.label, end, 1});
    end += segment.duration;
  }
  const std::size_t samples = static_cast<std::size_t>(std::llround(end)), fine = 40;
  for (const char* name : {"gyro", "x.accelerometer", "y.accelerometer"})
    recording.channels.push_back(
        {name, QuantityKind::count, Unit::parse("pulse"), {0.0, 1.0, nullptr}, std::vector<double>(samples, 0.0)});
  std::vector<Felt> felt(fine);
  for (std::size_t i = 0; i < samples; ++i) {
    reference.felt(static_cast<double>(i) + 0.5 / fine, 1.0 / fine, felt);
    for (const Felt& one : felt) {
      const Vector3 w = one.rate, f = one.specific_force;
      recording.channels[0].values[i] += t[0] * (w.x + t[1] + t[2] * w.y + t[3] * w.z) / fine;
      recording.channels[1].values[i] +=
          t[4] * (f.x + t[5] + t[6] * f.y + t[7] * f.z + second_order * f.x * f.x) / fine;
      recording.channels[2].values[i] += t[8] * (f.y + t[9] + t[10] * f.x + t[11] * f.z) / fine;
    }
  }
  Evidence evidence;
  evidence.plan = plan;
  evidence.recordings = {recording};
  return evidence;
}

Estimate answer(Evidence evidence, const char* estimator = "least_squares") {
  evidence.plan.settings.set_word("estimator", estimator);
  return method().identify(evidence, {});
}

double sd(const Estimate& estimate, const char* name) {
  return standard_uncertainty(estimate,
                              static_cast<std::size_t>(find_parameter(estimate, name) - estimate.parameters.data()));
}

/// What the accelerometers, where they do not fit the plan, show instead.
std::string meaning(const Estimate& estimate) {
  return text_of(estimate.findings, "accelerometers_do_not_fit_plan", "meaning");
}

Segment& segment(Plan& plan, const char* label) { return *std::ranges::find(plan.schedule, label, &Segment::label); }

/// A noisy test of the trial, after something was done to its plan before the recording and its recording after.
Evidence evidence_with(const std::function<void(Plan& recorded)>& before,
                       const std::function<void(Evidence&)>& after = {}) {
  Evidence evidence;
  evidence.plan = trial_plan(60.0, 2);
  Plan recorded = evidence.plan;
  if (before) before(recorded);
  evidence.recordings = {simulate(recorded, 7, {})};
  // the encoders would show it: here they were not recorded
  std::erase_if(evidence.recordings[0].channels, [](const Channel& c) { return c.name.ends_with("_angle"); });
  if (after) after(evidence);
  return evidence;
}

Estimate trial_with(const std::function<void(Plan& recorded)>& before,
                    const std::function<void(Evidence&)>& after = {}) {
  return answer(evidence_with(before, after));
}

// The table of positions (z_b and x_b, y_b in the laboratory: X horizontal at azimuth A, Y along the outer axis, Z up).
TEST(RlgNorthFinder, EveryPositionOfThePathFeelsWhatTheSourceSays) {
  const Plan plan = perfect();
  const double azimuth = si(53.0, "deg"), g = gravity(*plan.site);
  const Vector3 level = earth_rate_in_level(*plan.site);  // east, north, up
  const Vector3 earth{level.y * std::cos(azimuth), level.y * std::sin(azimuth), level.z};
  const Vector3 X{1, 0, 0}, Y{0, 1, 0}, Z{0, 0, 1};
  struct Row {
    const char* label;
    Vector3 x, y, z;
  };
  const Row rows[] = {{"1", X, Y, Z},
                      {"2", Z, Y, -1.0 * X},
                      {"3", Y, -1.0 * Z, -1.0 * X},
                      {"4", -1.0 * Z, -1.0 * Y, -1.0 * X},
                      {"5", -1.0 * Y, Z, -1.0 * X},
                      {"6", X, Y, Z},
                      {"7", -1.0 * X, Y, -1.0 * Z},
                      {"8", Y, X, -1.0 * Z}};
  const Reference reference = find_rig(plan.rig_kind).reference({plan.schedule, plan.rig, plan.site, 1.0});
  double end = 0.0;
  std::size_t seen = 0;
  for (const auto& one : plan.schedule) {
    end += one.duration;
    for (const Row& row : rows) {
      if (one.label != row.label) continue;
      ++seen;
      Felt felt;
      reference.felt(end - 1.0, 1.0, std::span(&felt, 1));
      const Vector3 force{g * row.x.z, g * row.y.z, g * row.z.z};
      const Vector3 rate{dot(earth, row.x), dot(earth, row.y), dot(earth, row.z)};
      EXPECT_LT(norm(felt.specific_force - force), 1e-12 * g) << row.label;
      EXPECT_LT(norm(felt.rate - rate), 1e-12 * earth_rate) << row.label;
    }
  }
  EXPECT_EQ(seen, 8u);
}

TEST(RlgNorthFinder, ForwardIsAPositiveRotationAboutTheBodyAxisNamed) {
  const Plan plan = perfect();
  const Reference reference = find_rig(plan.rig_kind).reference({plan.schedule, plan.rig, plan.site, 1.0});
  double begin = 0.0;
  for (const auto& one : plan.schedule) {
    Felt felt;
    reference.felt(begin + 60.0, 1.0, std::span(&felt, 1));
    begin += one.duration;
    if (!one.label.starts_with("about")) continue;
    const double sign = one.label.ends_with("forward") ? 1.0 : -1.0;
    const Vector3 axis{one.label[6] == 'x' ? sign : 0.0, one.label[6] == 'y' ? sign : 0.0,
                       one.label[6] == 'z' ? sign : 0.0};
    EXPECT_LT(norm(felt.rate - si(20.0, "deg/s") * axis), 2.0 * earth_rate) << one.label;
  }
}

// Midpoints of 40 instants a sample leave 1e-3^2 of what changes within one: the Earth's rate during rotations, 1e-9 of
// the angle.
TEST(RlgNorthFinder, BothEstimatorsGiveTheTruthOfATestWithoutNoise) {
  const Evidence evidence = unrounded(perfect());
  const auto truth = truth_of(evidence.plan);
  for (const char* estimator : {"least_squares", "closed_form"}) {
    const Estimate estimate = answer(evidence, estimator);
    for (std::size_t p = 0; p < truth.size(); ++p)
      EXPECT_NEAR(estimate.parameters[p].value, truth[p], 1e-9 * std::max(std::abs(truth[p]), 1e-4))
          << estimator << " " << estimate.parameters[p].name;
    EXPECT_TRUE(errors_among(estimate.findings).empty()) << estimate.findings.front().message;
  }
}

/// The plan with a table of these standard uncertainties of level and orthogonality [rad], and no other errors.
Plan stating_tilts(Plan plan, double sd) {
  plan.rig.set_flag("ideal", false);
  for (const char* name : {"index_zero_sd", "wobble_once_sd", "wobble_twice_sd"})
    plan.rig.set_number(name, 0.0, Unit::parse("arcsec"));
  for (const char* name : {"level_sd", "orthogonality_sd"}) plan.rig.set_number(name, sd, Unit::parse("arcsec"));
  return plan;
}

// 20 arcsec about X, about Y, and between the axes; the formulas take the table as perfect, and least squares subtracts
// what the eighth position shows. rho_X about X (azimuth A): east sin A, north cos A.
TEST(RlgNorthFinder, TiltsEnterTheFormulasOneToOneAndLeastSquaresSubtractsThem) {
  const Plan plan = stating_tilts(perfect(300.0, 2), 20.0 * arcsec);
  const Estimate sound = answer(unrounded(perfect(300.0, 2)), "closed_form");
  const double a = si(53.0, "deg"), tilt = 20.0 * arcsec;
  struct Row {
    RigErrors errors;
    double xy, yx, xz, yz;
  };
  const Row rows[] = {
      {{{"level of the base about east", tilt * std::sin(a)}, {"level of the base about north", tilt * std::cos(a)}},
       -tilt,
       tilt,
       0.0,
       0.0},
      {{{"level of the base about east", -tilt * std::cos(a)}, {"level of the base about north", tilt * std::sin(a)}},
       0.0,
       0.0,
       -tilt,
       0.0},
      {{{"orthogonality of inner to outer", tilt}}, 0.0, 0.0, 0.0, -tilt}};
  for (const Row& row : rows) {
    const Evidence evidence = unrounded(plan, row.errors);
    const Estimate formulas = answer(evidence, "closed_form"), all = answer(evidence);
    const std::pair<const char*, double> expected[] = {{"accelerometer_x.misalignment_y", row.xy},
                                                       {"accelerometer_y.misalignment_x", row.yx},
                                                       {"accelerometer_x.misalignment_z", row.xz},
                                                       {"accelerometer_y.misalignment_z", row.yz}};
    for (const auto& [name, change] : expected) {
      EXPECT_NEAR(value(formulas, name) - value(sound, name), change, 0.05 * arcsec) << name;
      EXPECT_NEAR(value(all, name), value(sound, name), 2.0 * arcsec) << name;
      EXPECT_LT(sd(all, name), 4.0 * arcsec) << name;
      EXPECT_GT(sd(formulas, name), 10.0 * arcsec) << name;
    }
    // the gyro is immune in first order: 20 arcsec times its misalignment of 110 arcsec are 5e-8
    EXPECT_NEAR(value(formulas, "gyro.scale_factor") / value(sound, "gyro.scale_factor"), 1.0, 1e-7);
    EXPECT_NEAR(value(formulas, "gyro.misalignment_z"), value(sound, "gyro.misalignment_z"), 0.05 * arcsec);
  }
}

// b + K_2 g^2/2 over the four positions: 4.80e-4 m/s^2 for K_2 = 1e-5 s^2/m.
TEST(RlgNorthFinder, ASecondOrderTermShiftsTheBias) {
  const Plan plan = perfect(300.0, 2);
  const double g = gravity(*plan.site), k2 = 1e-5;
  const double shift = value(answer(unrounded(plan, {}, k2), "closed_form"), "accelerometer_x.bias") -
                       value(answer(unrounded(plan), "closed_form"), "accelerometer_x.bias");
  EXPECT_NEAR(shift, 0.5 * k2 * g * g, 1e-7);
}

// N per sqrt(s) of white noise: u(K)/K = N sqrt(T_r/2)/Theta, the same for the misalignments; u(eps) = N/sqrt(4 T) of
// the four positions, to which the others add a little.
TEST(RlgNorthFinder, UncertaintiesAreThoseOfTheFormulasOfTheSource) {
  Plan plan = trial_plan(420.0, 10);
  plan.rig.set_flag("ideal", true);
  plan.truth.set_number("bias_instability", 0.0, Unit());
  const double n = si(0.005, "deg/sqrt(h)"), theta = 20.0 * std::numbers::pi;
  plan.truth.set_number("angle_random_walk", n, Unit::parse("deg/sqrt(h)"));
  plan.settings.set_word("estimator", "least_squares");
  const Estimate predicted = method().predict(plan);
  const auto& rotation = segment(plan, "about x, forward");
  // counting: two readings of a quarter of a fringe, each
  const double reading = 1.0 / std::sqrt(12.0) / value(predicted, "gyro.scale_factor");
  const double of_scale = std::hypot(n * std::sqrt(rotation.duration / 2.0), reading) / theta;
  EXPECT_NEAR(sd(predicted, "gyro.scale_factor") / value(predicted, "gyro.scale_factor") / of_scale, 1.0, 0.03);
  EXPECT_NEAR(sd(predicted, "gyro.misalignment_z") / of_scale, 1.0, 0.03);
  EXPECT_NEAR(sd(predicted, "gyro.misalignment_y") / of_scale, 1.0, 0.03);
  const double stay = 420.0 - 5.0 - 14.0;  // settling, and moves of 90 deg with 2 deg/s^2
  EXPECT_LT(sd(predicted, "gyro.bias"), n / std::sqrt(4.0 * stay));
  double all = 0.0;
  for (const auto& one : plan.schedule) all += one.duration;
  EXPECT_GT(sd(predicted, "gyro.bias"), n / std::sqrt(all));
  const auto truth = truth_of(plan);
  for (std::size_t p = 0; p < truth.size(); ++p)
    EXPECT_NEAR(predicted.parameters[p].value, truth[p], 2e-5 * std::abs(truth[p])) << predicted.parameters[p].name;
}

// No scale factor of the accelerometers is left then, so that nothing can be answered; but why is said.
TEST(RlgNorthFinder, ExchangedPositionsAreNamed) {
  for (const auto& [first, second] : {std::pair{"3", "4"}, {"5", "6"}}) {
    Evidence evidence =
        evidence_with([&](Plan& plan) { std::swap(segment(plan, first).axes, segment(plan, second).axes); });
    const auto message = refusal(method(), evidence);
    EXPECT_TRUE(refuses(Error::Kind::bad_data, asked_finding("positions_look_exchanged", {first, second}), message));
  }
}

/// Angles of an axis with the opposite sign, in these segments or, without any, in all.
std::function<void(Plan&)> mirrored(const char* axis, const std::vector<std::string>& labels = {}) {
  return [=](Plan& plan) {
    for (auto& one : plan.schedule) {
      if (!labels.empty() && std::ranges::find(labels, one.label) == labels.end()) continue;
      if (!one.axes.contains(axis)) continue;
      one.axes[axis].value *= one.axes[axis].kind == Type::hold ? -1.0 : 1.0;
      one.axes[axis].to *= -1.0;
    }
  };
}

std::function<void(Evidence&)> reversed(const std::vector<std::string>& channels) {
  return [=](Evidence& evidence) {
    for (auto& channel : evidence.recordings[0].channels)
      if (std::ranges::find(channels, channel.name) != channels.end())
        for (double& v : channel.values) v = -v;
  };
}

// The accelerometers see the same where they are reversed and where positions are taken the other way round: what the
// gyro shows of the Earth's rate decides.
TEST(RlgNorthFinder, WhatTheAccelerometersLeaveOpenTheGyroDecides) {
  const std::vector<std::string> upright{"2", "3", "4", "5"};
  const auto exchanged = [](const char* one, const char* other) {
    return [=](Plan& plan) { std::swap(segment(plan, one).axes, segment(plan, other).axes); };
  };
  EXPECT_EQ(meaning(trial_with(mirrored("outer", upright))), "first_turn_reversed");
  EXPECT_EQ(meaning(trial_with(mirrored("inner", upright))), "turns_about_z_reversed");
  EXPECT_EQ(meaning(trial_with(mirrored("outer"))), "outer_axis_reversed");
  EXPECT_EQ(meaning(trial_with(mirrored("inner"))), "inner_axis_reversed");
  EXPECT_EQ(meaning(trial_with(exchanged("2", "4"))), "x_positions_exchanged");
  EXPECT_EQ(meaning(trial_with(exchanged("3", "5"))), "turns_about_z_reversed");
  EXPECT_EQ(meaning(trial_with({}, reversed({"x.accelerometer"}))), "x_reversed");
  EXPECT_EQ(meaning(trial_with({}, reversed({"y.accelerometer"}))), "y_reversed");
  EXPECT_EQ(meaning(trial_with({}, reversed({"x.accelerometer", "y.accelerometer"}))), "x_and_y_reversed");
}

// At the equator the stays with x up and down show no Earth's rate to tell the two cases apart: both are named.
TEST(RlgNorthFinder, AtTheEquatorBothReadingsAreNamed) {
  const auto at_equator = [](Plan& plan) { plan.site->latitude = 0.0; };
  Evidence evidence;
  evidence.plan = trial_plan(60.0, 2);
  at_equator(evidence.plan);
  evidence.recordings = {simulate(evidence.plan, 7, {})};
  reversed({"x.accelerometer"})(evidence);
  EXPECT_EQ(meaning(answer(evidence)), "x_reversed_or_x_positions_exchanged");
}

// Forward and reverse exchanged reverse the sign of a misalignment, which no total of counts shows.
TEST(RlgNorthFinder, RotationsAboutAnotherAxisOrTheOtherWayAreNamed) {
  const auto exchanged = [](const std::string& axis) {
    return [=](Evidence& evidence) {
      const auto& marks = evidence.recordings[0].marks;
      const auto begin = [&](const std::string& label) {
        const auto found = std::ranges::find(marks, label, &Mark::label);
        return static_cast<std::ptrdiff_t>(found->begin);
      };
      const auto forward = begin("about " + axis + ", forward"), reverse = begin("about " + axis + ", reverse");
      for (auto& channel : evidence.recordings[0].channels)  // both are as long
        std::swap_ranges(channel.values.begin() + forward, channel.values.begin() + reverse,
                         channel.values.begin() + reverse);
    };
  };
  for (const char* axis : {"x", "y", "z"}) {
    const Findings findings = trial_with({}, exchanged(axis)).findings;
    const bool upright = std::string(axis) == "z";  // gravity does not show a turn about the vertical
    EXPECT_TRUE(has_error(findings, upright ? "rotation_reversed_by_earth_rate" : "rotation_reversed_by_gravity"))
        << axis;
  }
  // 7 and 8 in the other order: the rotation meant to be about x is about y
  const auto other_order = [](Plan& plan) { std::swap(segment(plan, "7").axes, segment(plan, "8").axes); };
  const auto message = refusal(method(), evidence_with(other_order));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, asked_finding("rotation_about_other_axis", {"x"}), message));
  // one turn about y instead of two, both ways
  const auto short_of = [](Plan& plan) { segment(plan, "about y, forward").axes.at("outer").to -= si(360.0, "deg"); };
  const Findings short_turns = trial_with(short_of).findings;
  EXPECT_TRUE(has_error(short_turns, "turns_do_not_fit_gravity"));
  EXPECT_EQ(text_of(short_turns, "turns_do_not_fit_gravity", "channel"), "accelerometer_x");
  EXPECT_EQ(value_of(short_turns, "turns_do_not_fit_gravity", "turns"), 1.0);
  EXPECT_NEAR(value_of(short_turns, "turns_do_not_fit_gravity", "planned"), 2.0, 0.01);
  const Estimate sound = trial_with({});
  EXPECT_TRUE(errors_among(sound.findings).empty()) << errors_among(sound.findings).front().text();
}

// A dither of which 20 deg/s is the 80th multiple over the scale factor, and one where it lies between two of them.
TEST(RlgNorthFinder, RotationsNearAMultipleOfDitherOverScaleAreNamed) {
  Evidence evidence;
  evidence.plan = trial_plan(60.0, 2);
  const double scale = truth_of(evidence.plan)[0];  // [pulse/rad]
  const double rate = si(20.0, "deg/s");
  evidence.recordings = {simulate(evidence.plan, 7, {})};
  const auto with = [&](double multiples) {
    evidence.plan.settings.set_number("dither_frequency", rate * scale / multiples, Unit::parse("Hz"));
    return finding_of(answer(evidence).findings, "rate_near_dither_multiple") != nullptr;
  };
  EXPECT_TRUE(with(80.0));
  EXPECT_FALSE(with(80.5));  // half of 0.25 deg/s off
}

// Before, the tilt went into the drift between positions, in which it was then lost. Stated as it is, all is well.
TEST(RlgNorthFinder, ATableTiltedFarBeyondWhatThePlanSaysIsNamed) {
  Plan plan = trial_plan(60.0, 2);
  const auto level = [](Plan& of, double sd) {
    of.rig.set_number("level_sd", si(sd, "arcsec"), Unit::parse("arcsec"));
  };
  level(plan, 600.0);
  for (const std::uint64_t seed : {7, 9}) {  // drawn: 56 and 243 arcsec about X
    Evidence evidence{plan, {simulate(plan, seed, {})}};
    EXPECT_FALSE(has_error(answer(evidence).findings, "tilt_beyond_rig")) << seed;
    level(evidence.plan, 10.0);
    EXPECT_TRUE(has_error(answer(evidence).findings, "tilt_beyond_rig")) << seed;
    EXPECT_TRUE(has_error(answer(evidence, "closed_form").findings, "tilt_beyond_rig")) << seed;
  }
}

TEST(RlgNorthFinder, ExchangedAndReversedAccelerometersAreNamedSeparately) {
  const auto exchanged = [](Evidence& e) {
    std::swap(e.plan.channels["accelerometer_x"], e.plan.channels["accelerometer_y"]);
  };
  EXPECT_EQ(meaning(trial_with({}, exchanged)), "accelerometers_exchanged");
  EXPECT_EQ(meaning(trial_with({}, reversed({"x.accelerometer"}))), "x_reversed");
}

TEST(RlgNorthFinder, AMissingRotationSaysWhichTermIsLost) {
  const auto without = [](const char* label) {
    Evidence evidence;
    evidence.plan = trial_plan(60.0, 2);
    std::erase_if(evidence.plan.schedule, [&](const Segment& s) { return s.label.starts_with(label); });
    evidence.recordings = {simulate(evidence.plan, 7, {})};
    return evidence;
  };
  Evidence evidence = without("about z");
  const Estimate weak = answer(evidence);
  EXPECT_TRUE(has_error(weak.findings, "no_rotations_about_axis"));
  EXPECT_EQ(text_of(weak.findings, "no_rotations_about_axis", "parameter"), "gyro.misalignment_z");
  EXPECT_GT(sd(weak, "gyro.misalignment_z"), si(30.0, "arcsec"));
  evidence.plan.settings.set_word("estimator", "closed_form");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, asked_finding("no_rotations_about_axis", {"gyro.misalignment_z"}),
                      refusal(method(), evidence)));
  EXPECT_FALSE(answer(without("7")).parameters.empty());
}

TEST(RlgNorthFinder, TurnsThatAreNotWholeAreNamed) {
  // by the plan
  Evidence evidence;
  evidence.plan = trial_plan(60.0, 2);
  segment(evidence.plan, "about x, forward").axes.at("outer").to += si(90.0, "deg");
  segment(evidence.plan, "about x, forward").duration += 5.0;
  segment(evidence.plan, "about x, reverse").duration += 5.0;
  evidence.recordings = {simulate(evidence.plan, 7, {})};
  EXPECT_TRUE(has_error(answer(evidence).findings, "turns_not_whole"));
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, asked_finding("turns_not_whole"), [&] { answer(evidence, "closed_form"); }));
  // by the counts: the reverse one ends half a degree before the mark
  const auto past = [](Plan& plan) { segment(plan, "about x, reverse").axes.at("outer").to += si(0.5, "deg"); };
  EXPECT_TRUE(has_error(trial_with(past).findings, "forward_and_reverse_differ"));
  // one turn instead of two, both ways: the Earth's rate at rest shows it
  const auto short_of = [](Plan& plan) { segment(plan, "about x, forward").axes.at("outer").to -= si(360.0, "deg"); };
  EXPECT_TRUE(has_error(trial_with(short_of).findings, "turns_do_not_fit_earth_rate"));
}

TEST(RlgNorthFinder, RotationsTheOtherWayAreSeenAgainstTheEarth) {
  const auto swapped = [](Plan& plan) {
    const double from = si(180.0, "deg"), angle = si(720.0, "deg");
    segment(plan, "about x, forward").axes.at("outer").to = from - angle;
  };
  EXPECT_TRUE(has_error(trial_with(swapped).findings, "rotation_reversed_by_scale_factor"));
}

TEST(RlgNorthFinder, AReversedGyroIsAnError) {
  const auto reversed = trial_with({}, [](Evidence& evidence) {
    for (Channel& channel : evidence.recordings[0].channels)
      if (channel.name == "gyro")
        for (double& count : channel.values) count = -count;
  });
  EXPECT_TRUE(has_error(reversed.findings, "gyro_counts_down"));
  EXPECT_LT(value(reversed, "gyro.scale_factor"), 0.0);
  EXPECT_FALSE(has_finding(trial_with({}).findings, "gyro_counts_down"));
}

/// A degree of misalignment takes 150 ppm from the scale factor by its cosine, which is known to less than 1 ppm.
TEST(RlgNorthFinder, ABodyThatIsNotAlongTheTableIsAnError) {
  const auto off =
      trial_with([](Plan& plan) { plan.schedule.front().axes["mount_pitch"] = {.value = si(1.0, "deg")}; });
  EXPECT_TRUE(has_error(off.findings, "misalignment_changes_scale_factor"));
  EXPECT_FALSE(has_finding(trial_with({}).findings, "misalignment_changes_scale_factor"));
}

/// A table that needs 30 % longer for its turns than the plan says comes to rest after the segment.
TEST(RlgNorthFinder, ATurnThatIsNotOverIsAnError) {
  Evidence evidence;
  evidence.plan = trial_plan(60.0, 2);
  Plan slow = evidence.plan;
  for (const char* option : {"outer_max_rate", "inner_max_rate"})
    slow.rig.set_number(option, si(14.0, "deg/s"), Unit::parse("deg/s"));
  evidence.recordings = {simulate(slow, 7, {})};
  EXPECT_TRUE(has_error(answer(evidence).findings, "move_not_over"));
}

TEST(RlgNorthFinder, RecordedAnglesReplaceThePlan) {
  Evidence evidence;
  evidence.plan = trial_plan(60.0, 2);
  Plan recorded = evidence.plan;
  segment(recorded, "3").axes.at("inner").value += si(0.3, "deg");
  segment(recorded, "about x, forward").axes.at("outer").to += si(0.5, "deg");
  std::swap(segment(recorded, "2").axes, segment(recorded, "4").axes);
  evidence.recordings = {simulate(recorded, 7, {})};
  const Estimate estimate = answer(evidence);
  const Finding* off = finding_of(estimate.findings, "angle_off_plan");
  ASSERT_NE(off, nullptr);
  EXPECT_GE(off->occurrences.count, 4u);  // 2 and 4 (the inner axis, as exchanged), 3, the end of a turn forward
  EXPECT_EQ(off->occurrences.worst.label, "2");
  const auto truth = truth_of(evidence.plan);
  for (std::size_t p = 0; p < truth.size(); ++p)
    EXPECT_LT(std::abs(estimate.parameters[p].value - truth[p]), 5.0 * standard_uncertainty(estimate, p))
        << estimate.parameters[p].name;
}

TEST(RlgNorthFinder, ALockedGyroIsNamed) {
  const auto locked = [](Plan& plan) { plan.truth.set_number("lock_in_rate", si(0.1, "deg/s"), Unit::parse("deg/s")); };
  EXPECT_TRUE(has_error(trial_with(locked).findings, "gyro_locked_in"));
}

TEST(RlgNorthFinder, DitherThatIsCutOffIsNamedWithItsSize) {
  const auto swinging = [](Evidence& e) {
    auto& values = e.recordings[0].channels[0].values;
    const double scale = truth_of(e.plan)[0] * 143.0 * arcsec;
    const auto at = [&](std::size_t i) { return std::floor(scale * std::sin(2.0 * static_cast<double>(i * i))); };
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += at(i + 1) - at(i);
  };
  // an amplitude drawn from sin(2 i^2) and rounded to counts is that of a sine to 4/sqrt(600 samples)
  EXPECT_NEAR(value_of(trial_with({}, swinging).findings, "dither_cut_off", "amplitude") / (143.0 * arcsec), 1.0, 0.16);
  EXPECT_EQ(finding_of(trial_with({}).findings, "dither_cut_off"), nullptr);
}

TEST(RlgNorthFinder, ATableThatKeepsMovingIsNamed) {
  const auto creeping = [](Evidence& e) {
    const auto& marks = e.recordings[0].marks;
    for (auto& channel : e.recordings[0].channels)
      if (channel.name == "x.accelerometer")  // 2 deg/min where x is level
        for (double t = marks[4].begin; t < marks[5].begin; t += 1.0)
          channel.values[static_cast<std::size_t>(t)] += 1e5 * si(2.0, "deg") / 60.0 * (t - marks[4].begin);
  };
  const Findings findings = trial_with({}, creeping).findings;
  EXPECT_TRUE(has_error(findings, "counts_not_at_rest"));
  EXPECT_EQ(text_of(findings, "counts_not_at_rest", "stays"), "'5'");
}

TEST(RlgNorthFinder, UnequalTimesAreSaidAndTakenIntoAccount) {
  Evidence evidence = unrounded(perfect(60.0, 2));
  Plan plan = perfect(60.0, 2);
  segment(plan, "about x, reverse").duration += 20.0;
  evidence = unrounded(plan);
  const auto truth = truth_of(plan);
  const Estimate all = answer(evidence), formulas = answer(evidence, "closed_form");
  EXPECT_NE(finding_of(all.findings, "unequal_times"), nullptr);
  EXPECT_NE(finding_of(formulas.findings, "unequal_times_in_formulas"), nullptr);
  EXPECT_NEAR(all.parameters[0].value / truth[0], 1.0, 1e-9);
  EXPECT_GT(std::abs(formulas.parameters[0].value / truth[0] - 1.0), 1e-6);
}

TEST(RlgNorthFinder, OutputsThatDoNotCountAreRefused) {
  Evidence evidence;
  evidence.plan = trial_plan(60.0, 2);
  evidence.plan.truth.set_word("output", "rate");
  evidence.recordings = {simulate(evidence.plan, 7, {})};
  const auto message = refusal(method(), evidence);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "needs counts"}, message));
}

/// The evidence with stamps, and without the samples [begin, end).
Evidence with_gap(Evidence evidence, std::size_t begin, std::size_t end) {
  for (Channel& channel : evidence.recordings[0].channels) {
    std::vector<double> stamps, values;
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      if (i < begin || i >= end) stamps.push_back(channel.time(i)), values.push_back(channel.values[i]);
    channel.values = std::move(values);
    channel.timeline = {0.0, 0.0, std::make_shared<const std::vector<double>>(std::move(stamps))};
  }
  return evidence;
}

// Counts are pulses in a sample of the clock: lost samples must not change the value of a count. A third of one stay of
// fourteen segments adds less than its noise.
TEST(RlgNorthFinder, LostSamplesDoNotShiftAResult) {
  const Evidence evidence = trial(7).evidence;
  const Evidence part = with_gap(evidence, 30, 50);
  for (const char* estimator : {"least_squares", "closed_form"}) {
    const Estimate before = answer(evidence, estimator), after = answer(part, estimator);
    EXPECT_TRUE(errors_among(after.findings).empty());
    for (std::size_t p = 0; p < before.parameters.size(); ++p)
      EXPECT_NEAR(after.parameters[p].value, before.parameters[p].value, standard_uncertainty(before, p))
          << estimator << " " << before.parameters[p].name;
  }
}

// Counts that alternate by A have a covariance of -A^2 with their neighbours, which gives an amplitude of sqrt(2) A,
// less 1 in 110 for the ends of the stays. 60 of 1000 s are lost: the mean rate would give 6 % more; the ends of the
// gaps change it by less than 1 %.
TEST(RlgNorthFinder, LostSamplesDoNotChangeTheAmplitudeOfTheDither) {
  const auto alternating = [](Evidence& evidence) {
    auto& values = evidence.recordings[0].channels[0].values;
    const double amplitude = truth_of(evidence.plan)[0] * 300.0 * arcsec;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += (i % 2 == 0 ? amplitude : -amplitude);
  };
  const Evidence evidence = evidence_with({}, alternating);
  Evidence part = evidence;
  for (const std::size_t begin : {30, 70, 110}) part = with_gap(part, begin, begin + 20);
  const auto amplitude = [](const Evidence& of) {
    return value_of(answer(of).findings, "dither_cut_off", "amplitude") / (std::sqrt(2.0) * 300.0 * arcsec);
  };
  EXPECT_NEAR(amplitude(evidence), 1.0, 0.02);
  EXPECT_NEAR(amplitude(part) / amplitude(evidence), 1.0, 0.01);
}

/// A table that a hand sets to 0.3 deg, with its angles recorded: one warning, no error, by either estimator; both give
/// the truth. Before, nearly every such test had errors about tilts and about turns that are not whole.
TEST(RlgNorthFinder, AnglesSetByHandAreNoFault) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Trial trial = second_trial_of(method(), seed);
    for (const char* estimator : {"least_squares", "closed_form"}) {
      const Estimate estimate = answer(trial.evidence, estimator);
      EXPECT_TRUE(errors_among(estimate.findings).empty()) << errors_among(estimate.findings).front().text();
      const Finding* off = finding_of(estimate.findings, "angle_off_plan");
      ASSERT_NE(off, nullptr);
      EXPECT_GT(off->occurrences.count, 5u);
      for (const auto& [name, truth] : trial.truth) {
        const auto p = static_cast<std::size_t>(find_parameter(estimate, name) - estimate.parameters.data());
        EXPECT_LT(std::abs(estimate.parameters[p].value - truth), 5.0 * standard_uncertainty(estimate, p)) << name;
      }
    }
  }
}

// Encoders show how far each turn went, so that both senses must count alike to what the noise leaves: 30 ppm of two turns
// are 22 millidegrees.
TEST(RlgNorthFinder, SensesThatCountUnlikeAreSeenAgainstTheEncoders) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    Trial trial = trial_of(method(), seed);
    EXPECT_FALSE(has_finding(answer(trial.evidence).findings, "forward_and_reverse_differ"));
    for (auto& channel : trial.evidence.recordings[0].channels)
      if (channel.name == "gyro")
        for (double& v : channel.values) v += v > 0.0 ? std::round(30e-6 * v) : 0.0;
    EXPECT_TRUE(has_finding(answer(trial.evidence).findings, "forward_and_reverse_differ")) << seed;
  }
}

// Two positions in the other order leave the outer axis at another angle for the turns about z: the encoders show it.
TEST(RlgNorthFinder, PositionsInAnotherOrderAreNoFault) {
  Evidence evidence;
  evidence.plan = trial_plan(60.0, 2);
  Plan carried_out = evidence.plan;
  auto& schedule = carried_out.schedule;
  const auto five = std::ranges::find(schedule, "5", &Segment::label);
  five->axes["outer"] = {.value = si(-90.0, "deg")};
  std::iter_swap(five, five + 1);
  evidence.recordings = {simulate(carried_out, 7, {})};
  const Estimate estimate = answer(evidence);
  const auto truth = truth_of(evidence.plan);
  for (std::size_t p = 0; p < truth.size(); ++p)
    EXPECT_LT(std::abs(estimate.parameters[p].value - truth[p]), 4.0 * standard_uncertainty(estimate, p))
        << estimate.parameters[p].name;
  EXPECT_LT(sd(estimate, "gyro.misalignment_z"), si(20.0, "arcsec"));
}

}  // namespace
}  // namespace tumble::rlg_north_finder
