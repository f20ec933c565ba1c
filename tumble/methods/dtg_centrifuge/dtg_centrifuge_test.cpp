#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::dtg_centrifuge_test {
namespace {

using Complex = std::complex<double>;

const Method& method() { return find_method("dtg_centrifuge"); }

constexpr double radius = 2.5, g = 9.80665, earth = 7.292115e-5;

/// The instruments and the rig of a synthetic test, in closed form. At latitude zero the Earth adds nothing to the rate
/// of the arm, so that a = w_t^2 R to rounding.
struct Synthetic {
  std::vector<double> arm_rates;     ///< deg/s
  double net = 40.0;                 ///< deg/s
  double length = 900.0;             ///< s a level
  double rest = 10.0;                ///< s at rest before; 0: none
  double rate = 100.0;               ///< Hz
  double azimuth = 0.0, gain = 1.0;  ///< of the reference gyro
  double offset = 0.0;               ///< rad/s of the reference gyro while the arm turns: its misalignment toward Z
  Complex tilt = 0.0;                ///< rad: lean of the table's axis, in the frame of the arm
  double sd = 0.0;                   ///< rad/s a sample, of the gyro
  double sense = 1.0;                ///< -1: arm and table turn the other way
  double spin_up = 1.0;              ///< -1: spin axis down
  Complex own = 0.0;                 ///< (d_x + i d_y) of the reference gyro [rad/s/g]
  double D_xxx = 8e-4;               ///< deg/h/g^3
  int power_ups = 1;
  bool encoders = true;
  double lag = 0.0;         ///< s of the gyro's loop
  bool loop_stated = true;  ///< that there is no lag
  double sign = 1.0;        ///< of the gyro's output
};

Motion turning(double rate) {
  Motion motion;
  motion.kind = Motion::Kind::rate;
  motion.value = rate;
  return motion;
}

Plan plan_of(const Synthetic& s) {
  Plan plan =
      trial_plan("dtg_centrifuge", method().options(), "dynamically_tuned_gyro", "counter_rotating_centrifuge", s.rate);
  plan.site = Site{0.0, 0.0, 0.0, g};
  plan.rig.set_number("radius", radius, Unit::parse("m"));
  plan.rig.set_flag("ideal", true);
  for (const char* name : {"arm_max_acceleration", "table_max_acceleration"})
    plan.rig.set_number(name, 1e9, Unit::parse("deg/s^2"));
  if (s.loop_stated) plan.settings.set_number("time_constant", 0.0, Unit::parse("s"));
  for (const char* name : {"averaging", "reference_averaging", "settling"})
    plan.settings.set_number(name, 0.0, Unit::parse("s"));
  for (int run = 1; run <= s.power_ups; ++run) {
    Motion down;
    down.value = s.spin_up < 0.0 ? std::numbers::pi : 0.0;
    const auto add = [&](Segment segment) {
      segment.axes["mount_roll"] = down;
      plan.schedule.push_back(std::move(segment));
    };
    if (s.rest > 0.0) add({"static", s.rest, run, {}});
    int level = 1;
    for (const double rate : s.arm_rates) {
      Segment spin{fmt::format("spin {}", level++), s.length, run, {}};
      spin.axes["arm"] = turning(s.sense * si(rate, "deg/s"));
      spin.axes["table"] = turning(s.sense * si(s.net - rate, "deg/s"));
      add(spin);
    }
  }
  return plan;
}

/// Outputs at one instant: theta, beta, rates, docs/equations (1.2)-(1.5).
struct Outputs {
  double gyro, reference;
};

Outputs shown(const Synthetic& s, double arm_rate, double theta, double beta) {
  const double a = arm_rate * arm_rate * radius, unit = si(1.0, "deg/h");
  const Complex turn = std::polar(1.0, theta), heading = std::polar(1.0, -beta);
  const auto facing = [&](Complex v) { return Complex(v.real(), s.spin_up * v.imag()); };
  // y axis: Re(-i z e^{i theta}) = Im(z e^{i theta}); turned over with the spin axis down
  const Complex rate = facing(-arm_rate * s.tilt * turn + earth * heading);
  const Complex force = arm_rate == 0.0 ? 0.0 : facing((-a - g * s.tilt) * turn) / g;
  const double fx = force.real(), fy = force.imag(), fz = s.spin_up;
  const double drift = unit * (6.0 * fx - 2.5 * fy + 0.15 * fx * fz - 0.05 * fy * fz + s.D_xxx * fx * fx * fx + 4.0);
  const double reference = s.gain * (rate.real() * std::cos(s.azimuth) + rate.imag() * std::sin(s.azimuth)) +
                           s.own.real() * fx + s.own.imag() * fy + 2.0 * unit + (arm_rate == 0.0 ? 0.0 : s.offset);
  return {rate.real() + drift, reference};
}

Evidence evidence_of(const Synthetic& s, std::uint64_t seed = 1) {
  Evidence evidence;
  evidence.plan = plan_of(s);
  Recording recording;
  const Timeline clock{0.0, s.rate, nullptr};
  for (const char* name : {"gyro", "reference_gyro"})
    recording.channels.push_back({name, QuantityKind::angular_rate, Unit::parse("deg/h"), clock, {}});
  for (const char* name : {"arm_angle", "table_angle"})
    recording.channels.push_back({name, QuantityKind::angle, Unit::parse("deg"), clock, {}});
  double now = 0.0;
  std::uint64_t sample = 0;
  const RandomStream random(seed);
  for (const auto& segment : evidence.plan.schedule) {
    recording.marks.push_back({segment.label, now, segment.run});
    const bool spins = segment.axes.contains("arm");
    const double w_t = spins ? segment.axes.at("arm").value : 0.0;
    const double w_s = spins ? -segment.axes.at("table").value : 0.0;
    const auto count = static_cast<std::size_t>(std::llround(segment.duration * s.rate));
    for (std::size_t i = 0; i < count; ++i) {
      const double t = static_cast<double>(i) / s.rate, theta = w_s * t;
      Outputs out = shown(s, w_t, theta, (w_t - w_s) * t);
      if (s.lag != 0.0) out.gyro = shown(s, w_t, w_s * (t - s.lag), (w_t - w_s) * (t - s.lag)).gyro;
      out.gyro *= s.sign;
      recording.channels[0].values.push_back(out.gyro + (s.sd > 0.0 ? s.sd * random.normal(sample++) : 0.0));
      recording.channels[1].values.push_back(out.reference);
      recording.channels[2].values.push_back(w_t * t);
      recording.channels[3].values.push_back(-theta);
    }
    now += segment.duration;
  }
  if (!s.encoders) recording.channels.resize(2);
  evidence.recordings.push_back(std::move(recording));
  return evidence;
}

double cell(const Estimate& estimate, std::size_t row, const std::string& column) {
  const Table* table = find_table(estimate, "nonlinearity");
  for (std::size_t c = 0; c < table->columns.size(); ++c)
    if (table->columns[c].name == column)
      return table->columns[c].unit.difference_from_si(std::get<double>(table->rows.at(row)[c]));
  ADD_FAILURE() << "no column " << column;
  return std::nan("");
}

double K(const Estimate& estimate, int level = 1) {
  return value(estimate, fmt::format("sensitive_term_{}", level)) / si(1.0, "deg/h/g");
}

Synthetic five_levels() { return {.arm_rates = {114, 160, 254, 359, 508}}; }

// The source publishes no numbers; these are of a synthetic test of the same apparatus, to the digits printed. They
// were made by Fourier series: at 359 deg/s the whole periods end within a sample, and K printed is 2.1e-5 above the
// truth, hypot(6.15 + 6e-4 a^2, 2.55) = 6.713259, which is what a regression must give.
void expect_published(const Estimate& estimate, bool fourier) {
  const double a[] = {1.009, 1.988, 5.010, 10.008, 20.040};
  const double A[] = {-6.2073, -12.2308, -30.8872, -62.153, -128.076};
  const double B[] = {2.5735, 5.0694, 12.776, 25.521, 51.102};
  const double of_K[] = {6.65827, 6.65989, 6.67162, fourier ? 6.71328 : 6.71326, 6.88091};
  const double zeta[] = {0.0, 0.024, 0.200, 0.826, 3.344};
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(cell(estimate, k, "acceleration"), a[k], 6e-4);
    EXPECT_NEAR(cell(estimate, k, "A"), A[k], k < 3 ? 6e-5 : 6e-4);
    EXPECT_NEAR(cell(estimate, k, "B"), B[k], k < 2 ? 6e-5 : 6e-4);
    EXPECT_NEAR(cell(estimate, k, "K"), of_K[k], 6e-6);
    EXPECT_NEAR(cell(estimate, k, "zeta"), zeta[k], 6e-4);
  }
}

TEST(DtgCentrifuge, RegressionGivesTheSyntheticTable) {
  const Estimate estimate = method().identify(evidence_of(five_levels()), {});
  expect_published(estimate, false);
  EXPECT_NEAR(value(estimate, "D_x") / si(1.0, "deg/h/g"), 6.15, 1e-8);
  EXPECT_NEAR(value(estimate, "D_y") / si(1.0, "deg/h/g"), -2.55, 1e-8);
  EXPECT_NEAR(value(estimate, "D_xxx") / si(1.0, "deg/h/g^3"), 8e-4, 1e-9);
  EXPECT_NEAR(value(estimate, "D_xyy") / si(1.0, "deg/h/g^3"), 0.0, 1e-9);
  EXPECT_NEAR(value(estimate, "nonlinearity_5"), 0.03344, 6e-6);  // to the digits printed, as in the table
}

TEST(DtgCentrifuge, FourierGivesTheSyntheticTable) {
  Evidence evidence = evidence_of(five_levels());
  evidence.plan.settings.set_word("estimator", "fourier");
  const Estimate estimate = method().identify(evidence, {});
  expect_published(estimate, true);
  EXPECT_NE(finding_of(estimate.findings, "few_whole_periods"), nullptr);  // 114 and 160 deg/s: 185 and 300 in 15 min
}

Synthetic tilted() {
  return {.arm_rates = {342.3},
          .azimuth = si(1.0, "deg"),
          .gain = 1.001,
          .tilt = std::polar(si(40.0, "arcsec"), si(210.0, "deg")),
          .D_xxx = 0.0};
}

// With the tilt the gravity let in changes a by 1.9e-4 g in 9.1; K = |(6.15, 2.55)| = 6.65770. The true-rate line is
// 239 deg/h; what the plain difference leaves of it is 1.5 % of K.
TEST(DtgCentrifuge, RegressionSubtractsTheTrueRateOfATiltedTable) {
  Evidence evidence = evidence_of(tilted());
  const double truth = std::hypot(6.15, 2.55);
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_NEAR(K(estimate) / truth, 1.0, 1e-8);
  EXPECT_NEAR(value(estimate, "D_x") / si(6.15, "deg/h/g"), 1.0, 1e-8);
  evidence.plan.settings.set_word("estimator", "fourier");
  EXPECT_NEAR(K(method().identify(evidence, {})) / truth, 1.0146, 5e-4);
}

TEST(DtgCentrifuge, SenseAndOrientationDoNotMatter) {
  for (const double sense : {1.0, -1.0})
    for (const double spin : {1.0, -1.0}) {
      Synthetic s = tilted();
      s.sense = sense;
      s.spin_up = spin;
      const Estimate estimate = method().identify(evidence_of(s), {});
      EXPECT_NEAR(value(estimate, "D_x") / si(6.0 + spin * 0.15, "deg/h/g"), 1.0, 1e-7) << sense << spin;
      EXPECT_NEAR(value(estimate, "D_y") / si(-2.5 - spin * 0.05, "deg/h/g"), 1.0, 1e-7) << sense << spin;
    }
}

TEST(DtgCentrifuge, BothOrientationsSeparateDxFromDxz) {
  Synthetic s = five_levels();
  s.length = 60.0;
  s.tilt = std::polar(si(40.0, "arcsec"), 1.0);
  s.azimuth = si(1.0, "deg");
  Evidence evidence = evidence_of(s);
  s.spin_up = -1.0;
  Evidence down = evidence_of(s);
  evidence.plans = {nullptr, std::make_shared<const Plan>(down.plan)};
  evidence.recordings.push_back(down.recordings.front());
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_NEAR(value(estimate, "D_x") / si(6.0, "deg/h/g"), 1.0, 1e-7);
  EXPECT_NEAR(value(estimate, "D_xz") / si(0.15, "deg/h/g^2"), 1.0, 1e-6);
  EXPECT_NEAR(value(estimate, "D_yz") / si(-0.05, "deg/h/g^2"), 1.0, 1e-6);
  EXPECT_EQ(find_table(estimate, "nonlinearity")->rows.size(), 10u);
}

TEST(DtgCentrifuge, OrientationsMayShareOnePlan) {
  Plan plan = trial_of(method(), 1).evidence.plan;
  plan.rig.set_flag("ideal", true);
  set_truth(plan, "angle_random_walk", 0.0, "deg/sqrt(h)");
  plan.beside[0].truth.set_number("angle_random_walk", 0.0, Unit::parse("deg/sqrt(h)"));
  for (auto& segment : plan.schedule) {
    Motion mount;
    mount.value = segment.run % 2 == 0 ? std::numbers::pi : 0.0;
    segment.axes["mount_roll"] = mount;
  }
  const Estimate estimate = method().identify(Evidence{plan, {simulate(plan, 1, {})}}, {});
  EXPECT_NEAR(value(estimate, "D_x") / si(6.0, "deg/h/g"), 1.0, 1e-4);
  EXPECT_NEAR(value(estimate, "D_xz") / si(0.15, "deg/h/g^2"), 1.0, 1e-3);
  for (auto& segment : plan.schedule) segment.axes["mount_roll"].value = si(60.0, "deg");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"60"}, .pattern = "off the vertical"},
                      refusal(method(), Evidence{plan, {simulate(plan, 1, {})}})));
}

TEST(DtgCentrifuge, RatesAreFoundWithoutEncoders) {
  Synthetic s = five_levels();
  s.length = 120.0;
  s.azimuth = si(1.0, "deg");
  Evidence evidence = evidence_of(s);
  evidence.recordings[0].channels.resize(2);
  // the plan is off by 0.2 %
  for (auto& segment : evidence.plan.schedule)
    if (segment.axes.contains("arm")) segment.axes.at("arm").value *= 1.002, segment.axes.at("table").value *= 1.003;
  const Estimate estimate = method().identify(evidence, {});
  for (int k = 1; k <= 5; ++k)
    EXPECT_NEAR(K(estimate, k) / cell(method().identify(evidence_of(s), {}), static_cast<std::size_t>(k - 1), "K"), 1.0,
                1e-6);
  EXPECT_NE(finding_of(estimate.findings, "rates_differ_from_plan"), nullptr);
  EXPECT_EQ(find_parameter(estimate, "D_x"), nullptr);
}

TEST(DtgCentrifuge, ReferenceGyroThatFeelsSpecificForceIsDetected) {
  Synthetic s = five_levels();
  s.arm_rates = {114, 160, 200, 254, 359, 420, 508};
  s.length = 60.0;
  s.tilt = std::polar(si(40.0, "arcsec"), 1.0);
  s.own = Complex(si(0.2, "deg/h/g") * g, si(-0.1, "deg/h/g") * g);
  Evidence evidence = evidence_of(s);
  const Estimate plain = method().identify(evidence, {});
  EXPECT_NE(finding_of(plain.findings, "reference_sensitive_to_force"), nullptr);
  EXPECT_NEAR(value(plain, "D_x") / si(5.95, "deg/h/g"), 1.0, 1e-3);
  evidence.plan.settings.set_word("reference_sensitivity", "fitted");
  EXPECT_NEAR(value(method().identify(evidence, {}), "D_x") / si(6.15, "deg/h/g"), 1.0, 1e-6);
}

TEST(DtgCentrifuge, UnequalClocksDoNoHarm) {
  Synthetic s = five_levels();
  s.length = 60.0;
  s.azimuth = si(1.0, "deg");
  s.tilt = std::polar(si(40.0, "arcsec"), 1.0);
  Evidence evidence = evidence_of(s);
  const double before = K(method().identify(evidence, {}), 3);
  s.rate = 37.0;
  const Evidence slow = evidence_of(s);
  Channel& reference = evidence.recordings[0].channels[1];
  reference = slow.recordings[0].channels[1];
  // a sample is that of the middle of its interval: the closed form is that of the stamp
  reference.timeline.start += 0.5 / 100.0 - 0.5 / 37.0;
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_NEAR(K(estimate, 3) / before, 1.0, 1e-6);
}

TEST(DtgCentrifuge, GapsDoNotMatterToTheRegression) {
  Synthetic s = five_levels();
  s.length = 60.0;
  Evidence evidence = evidence_of(s);
  const double before = K(method().identify(evidence, {}), 3);
  for (std::size_t i = 14000; i < 14050; ++i)
    evidence.recordings[0].channels[0].values[i] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NEAR(K(method().identify(evidence, {}), 3) / before, 1.0, 1e-9);
  evidence.plan.settings.set_word("estimator", "fourier");
  EXPECT_NE(finding_of(method().identify(evidence, {}).findings, "samples_missing_in_whole_periods"), nullptr);
}

/// The recording without samples `first` to `last`, which the stamps show.
void lose(Recording& recording, std::size_t first, std::size_t last) {
  std::vector<double> stamps;
  for (std::size_t i = 0; i < recording.channels[0].values.size(); ++i)
    if (i < first || i >= last) stamps.push_back(recording.channels[0].time(i));
  const Timeline timeline{0.0, 0.0, std::make_shared<const std::vector<double>>(stamps)};
  for (Channel& channel : recording.channels) {
    const auto begin = channel.values.begin();
    channel.values.erase(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last));
    channel.timeline = timeline;
  }
}

// Each sample is the mean over its interval: a line loses 1 - sin(x)/x = x^2/6, x = w_s T/2 = 0.20 at 20 Hz and 468
// deg/s. A quarter of level 3 of 5 is lost, 5 % of the record: by the mean rate T would be 5 % longer and K 7e-4
// larger.
TEST(DtgCentrifuge, LostSamplesDoNotChangeIt) {
  Synthetic s = five_levels();
  s.length = 60.0;
  s.rate = 20.0;
  Evidence evidence = evidence_of(s);
  evidence.plan.settings = defaults(method().options());
  evidence.plan.settings.set_number("settling", 0.0, Unit::parse("s"));
  const double before = K(method().identify(evidence, {}), 5);
  lose(evidence.recordings[0], 200 + 2 * 1200 + 400, 200 + 2 * 1200 + 700);
  // without noise the least misfit is a doubt, which weighs the levels anew
  EXPECT_NEAR(K(method().identify(evidence, {}), 5) / before, 1.0, 1e-5);
  // the Fourier series counts what its level lacks
  evidence.plan.settings.set_word("estimator", "fourier");
  const Estimate fourier = method().identify(evidence, {});
  ASSERT_NE(finding_of(fourier.findings, "samples_missing_in_whole_periods"), nullptr);
  const auto missing = std::ranges::find(fourier.findings, "samples_missing_in_whole_periods", &Finding::code);
  EXPECT_NEAR(std::get<double>(missing->values[0].value), 300.0, 1.0);
  EXPECT_EQ(missing->where, "run 1, spin 3");
}

// Five levels have fewer than 500 whole periods each: one finding, not five that differ in their numbers.
TEST(DtgCentrifuge, RepeatsOfAFindingAreCountedByItsCode) {
  Synthetic s = five_levels();
  s.length = 60.0;
  Evidence evidence = evidence_of(s);
  evidence.plan.settings.set_word("estimator", "fourier");
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_EQ(std::ranges::count(estimate.findings, "few_whole_periods", &Finding::code), 1);
  const Finding& few = *std::ranges::find(estimate.findings, "few_whole_periods", &Finding::code);
  EXPECT_EQ(few.occurrences.count, 5u);
  EXPECT_EQ(few.occurrences.first.label, "run 1, spin 1");
  EXPECT_EQ(few.occurrences.worst.label, "run 1, spin 1");  // the table turns by 74 deg/s: 12 turns
  EXPECT_EQ(std::get<double>(few.values[0].value), 12.0);
  EXPECT_EQ(few.where, "run 1, spin 1; ...; run 1, spin 5");
}

TEST(DtgCentrifuge, AveragingAndLoopAreCorrected) {
  Synthetic s = five_levels();
  s.length = 60.0;
  Evidence evidence = evidence_of(s);
  // each sample the mean of 100 ms about it: a line loses sin(x)/x, x = w_s 50 ms; the reference the same
  const double before = K(method().identify(evidence, {}), 5), x = si(468.0, "deg/s") * 0.05;
  evidence.plan.settings.set_number("averaging", 0.1, Unit::parse("s"));
  evidence.plan.settings.set_number("reference_averaging", 0.1, Unit::parse("s"));
  EXPECT_NEAR(K(method().identify(evidence, {}), 5) / before, x / std::sin(x), 1e-6);
  evidence.plan.settings.set_number("averaging", 0.0, Unit::parse("s"));
  evidence.plan.settings.set_number("reference_averaging", 0.0, Unit::parse("s"));
  evidence.plan.settings.set_number("time_constant", 0.01, Unit::parse("s"));
  evidence.plan.settings.set_number("reference_time_constant", 0.01, Unit::parse("s"));
  EXPECT_NEAR(K(method().identify(evidence, {}), 5) / before, std::hypot(1.0, si(468.0, "deg/s") * 0.01), 1e-5);
}

TEST(DtgCentrifuge, LevelsWhereLinesMeetAreSkipped) {
  Synthetic s = five_levels();
  s.arm_rates = {80.0, 160.0, 254.0};
  s.length = 60.0;
  const Estimate estimate = method().identify(evidence_of(s), {});
  EXPECT_NE(finding_of(estimate.findings, "lines_coincide"), nullptr);
  EXPECT_EQ(find_table(estimate, "nonlinearity")->rows.size(), 2u);
  s.arm_rates = {60.0};
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, asked_finding("lines_coincide", {"2"}), refusal(method(), evidence_of(s))));
}

TEST(DtgCentrifuge, SaysWhatIsWrongWithARecording) {
  Synthetic s = five_levels();
  s.length = 60.0;
  const Evidence good = evidence_of(s);
  const auto level = [](std::size_t k) { return 1000 + 6000 * k; };

  Evidence evidence = good;  // reference clipped in the fourth level
  for (std::size_t i = level(3); i < level(4); ++i) {
    double& v = evidence.recordings[0].channels[1].values[i];
    v = std::min(v, si(6.0, "deg/h"));
  }
  EXPECT_NE(finding_of(method().identify(evidence, {}).findings, "channel_clipped"), nullptr);

  // the gyro in the second level too: another channel, another finding
  for (std::size_t i = level(1); i < level(2); ++i) {
    double& v = evidence.recordings[0].channels[0].values[i];
    v = std::min(v, si(6.0, "deg/h"));
  }
  EXPECT_EQ(std::ranges::count(method().identify(evidence, {}).findings, "channel_clipped", &Finding::code), 2);

  evidence = good;  // the fifth level slows down
  for (std::size_t i = level(4); i < level(5); ++i)
    for (const std::size_t c : {2u, 3u}) {
      const double share = static_cast<double>(i - level(4)) / 6000.0;
      evidence.recordings[0].channels[c].values[i] *= 1.0 - 0.01 * share;
    }
  EXPECT_NE(finding_of(method().identify(evidence, {}).findings, "rates_do_not_settle"), nullptr);

  evidence = good;  // the table's angle counted the other way
  for (double& v : evidence.recordings[0].channels[3].values) v = -v;
  EXPECT_TRUE(refuses(Error::Kind::bad_data, asked_finding("table_turns_the_other_way"), refusal(method(), evidence)));

  evidence = good;  // the plan has other rates
  for (auto& segment : evidence.plan.schedule)
    if (segment.axes.contains("table")) segment.axes.at("table").value += si(1.0, "deg/s");
  EXPECT_NE(finding_of(method().identify(evidence, {}).findings, "rates_differ_from_plan"), nullptr);

  s.rest = 0.0;  // no segment at rest
  evidence = evidence_of(s);
  EXPECT_NE(finding_of(method().identify(evidence, {}).findings, "no_static_segment"), nullptr);
  evidence.plan.settings.set_word("estimator", "fourier");
  EXPECT_NE(finding_of(method().identify(evidence, {}).findings, "mean_of_level_replaces_rest"), nullptr);
}

// sigma_A = 0.05 deg/h at every level: the sd of zeta at 20 g is 0.77 % by the ratio to the level at 1 g,
// docs/equations (1.11), and less than a fifth of it by the polynomial (1.13).
TEST(DtgCentrifuge, PolynomialMakesZetaFiveTimesAsGood) {
  Synthetic s;
  for (int k = 1; k <= 20; ++k) s.arm_rates.push_back(std::sqrt(k * g / radius) / si(1.0, "deg/s"));
  s.length = 60.0;
  s.rate = 20.0;
  s.sd = si(0.05, "deg/h") * std::sqrt(60.0 * 20.0 / 2.0);
  Evidence evidence = evidence_of(s);
  const auto sd = [&](const char* estimator) {
    evidence.plan.settings.set_word("estimator", estimator);
    const Estimate estimate = method().identify(evidence, {});
    const Parameter* zeta = find_parameter(estimate, "nonlinearity_20");
    return standard_uncertainty(estimate, static_cast<std::size_t>(zeta - estimate.parameters.data()));
  };
  const double fourier = sd("fourier"), regression = sd("regression");
  EXPECT_NEAR(fourier, 0.0077, 0.0008);
  EXPECT_LT(regression, fourier / 5.0);
}

double sd_of(const Estimate& estimate, const std::string& name) {
  const Parameter* p = find_parameter(estimate, name);
  return p == nullptr ? std::nan("")
                      : standard_uncertainty(estimate, static_cast<std::size_t>(p - estimate.parameters.data()));
}

// The cubic of 1.2e-4 deg/h/g^3 is twice its standard uncertainty: AICc would often choose none. Of 16 tests the mean
// square of z is 1 within 4 sqrt(2/16) = 1.4; with a cubic set to zero D_x was off by up to 45 standard uncertainties.
TEST(DtgCentrifuge, AnOrderThatNobodyStatesKeepsItsUncertainty) {
  Synthetic s = five_levels();
  s.length = 40.0;
  s.rate = 20.0;
  s.sd = si(14.0, "deg/h");
  s.D_xxx = 1.2e-4;
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    const Estimate estimate = method().identify(evidence_of(s, seed), {});
    squares += std::pow((value(estimate, "D_x") - si(6.15, "deg/h/g")) / sd_of(estimate, "D_x"), 2) / 16.0;
    for (const char* name :
         {"nonlinearity_2", "nonlinearity_3", "nonlinearity_4", "nonlinearity_5", "D_xxx", "D_yyy"}) {
      ASSERT_NE(find_parameter(estimate, name), nullptr) << name << " of seed " << seed;
      EXPECT_GT(sd_of(estimate, name), 1e-6 * std::abs(value(estimate, name))) << name;
    }
  }
  EXPECT_LT(squares, 2.4);
}

TEST(DtgCentrifuge, NonlinearityOfAConstantOrderIsThatOfTheLevels) {
  Synthetic s = five_levels();
  s.length = 40.0;
  s.rate = 20.0;
  s.sd = si(14.0, "deg/h");
  Evidence evidence = evidence_of(s);
  evidence.plan.settings.set_word("order", "constant");
  const Estimate estimate = method().identify(evidence, {});
  for (std::size_t level = 2; level <= 5; ++level) {
    const std::string name = fmt::format("nonlinearity_{}", level);
    EXPECT_NEAR(100.0 * value(estimate, name), cell(estimate, level - 1, "zeta"), 1e-9);
    EXPECT_GT(sd_of(estimate, name), 1e-4);
  }
}

TEST(DtgCentrifuge, ThreeLevelsKeepTheCubic) {
  Synthetic s;
  s.arm_rates = {114, 254, 508};
  s.length = 40.0;
  s.rate = 20.0;
  s.sd = si(14.0, "deg/h");
  s.D_xxx = 0.0;
  const Estimate estimate = method().identify(evidence_of(s), {});
  EXPECT_NE(find_parameter(estimate, "D_xxx"), nullptr);
  EXPECT_EQ(find_parameter(estimate, "p_4"), nullptr);
  EXPECT_GT(sd_of(estimate, "nonlinearity_3"), 1e-5);
}

// A lag of 8 ms turns the sensitive term by w_s T = 3.7 deg at 468 deg/s.
TEST(DtgCentrifuge, TheLagOfALoopThatNobodyStatedIsEstimated) {
  Synthetic s = tilted();
  s.arm_rates = {114, 160, 254, 359, 440, 508};
  s.length = 60.0;
  s.D_xxx = 8e-4;
  s.lag = 0.008;
  s.loop_stated = false;
  s.sd = si(0.5, "deg/h");
  const Estimate estimate = method().identify(evidence_of(s), {});
  EXPECT_NE(finding_of(estimate.findings, "loop_lag_estimated"), nullptr);
  const auto near = [&](const char* name, double truth) {
    EXPECT_NEAR(value(estimate, name), truth, 4.0 * sd_of(estimate, name)) << name;
  };
  near("loop_lag", 0.008);
  near("D_x", si(6.15, "deg/h/g"));
  near("D_y", si(-2.55, "deg/h/g"));
  near("reference_azimuth", si(1.0, "deg"));
  near("sensitive_term_6", si(std::hypot(6.15 + 6e-4 * std::pow(20.0404, 2), 2.55), "deg/h/g"));
  EXPECT_LT(sd_of(estimate, "D_y"), si(0.1, "deg/h/g"));
  EXPECT_LT(sd_of(estimate, "loop_lag"), 0.004);
}

TEST(DtgCentrifuge, ALoopThatTheLevelsContradictIsNamed) {
  Synthetic s = five_levels();
  s.length = 60.0;
  s.sd = si(0.5, "deg/h");
  EXPECT_EQ(finding_of(method().identify(evidence_of(s), {}).findings, "loop_lag_differs"), nullptr);
  s.lag = 0.02;  // stated: none
  EXPECT_NE(finding_of(method().identify(evidence_of(s), {}).findings, "loop_lag_differs"), nullptr);
}

/// Six levels of a minute with noise, and no loop, as stated.
Synthetic noisy() {
  Synthetic s = tilted();
  s.arm_rates = {114, 160, 254, 359, 440, 508};
  s.length = 60.0;
  s.D_xxx = 8e-4;
  s.sd = si(0.5, "deg/h");
  return s;
}

// 20 ms turn the sensitive term by 9 deg at 468 deg/s, and the true rate that is subtracted too.
TEST(DtgCentrifuge, StampsOfBothGyrosThatAreLateAreTakenOut) {
  Evidence evidence = evidence_of(noisy());
  for (const std::size_t k : {0, 1}) evidence.recordings[0].channels[k].timeline.start += 0.02;
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_NE(finding_of(estimate.findings, "gyros_late_on_angles"), nullptr);
  EXPECT_EQ(finding_of(estimate.findings, "loop_lag_differs"), nullptr);
  EXPECT_EQ(finding_of(estimate.findings, "levels_off_polynomial"), nullptr);
  EXPECT_NEAR(value(estimate, "D_x"), si(6.15, "deg/h/g"), 4.0 * sd_of(estimate, "D_x"));
  EXPECT_NEAR(value(estimate, "D_y"), si(-2.55, "deg/h/g"), 4.0 * sd_of(estimate, "D_y"));
  EXPECT_LT(sd_of(estimate, "D_y"), si(0.1, "deg/h/g"));
}

// One net rate in one sense: a lag and a sensitivity to specific force look alike.
TEST(DtgCentrifuge, AReferenceGyroAloneThatIsLateIsNamed) {
  Evidence evidence = evidence_of(noisy());
  evidence.recordings[0].channels[1].timeline.start += 0.02;
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_NE(finding_of(estimate.findings, "reference_late_or_sensitive"), nullptr);
  EXPECT_EQ(finding_of(estimate.findings, "reference_sensitive_to_force"), nullptr);
  EXPECT_EQ(finding_of(estimate.findings, "gyros_late_on_angles"), nullptr);
}

/// A low pass of first order as a program makes it, behind a channel.
void smooth(double lag, Channel& channel) {
  const double part = 1.0 / (1.0 + lag * channel.timeline.rate);
  double shown = channel.values.front();
  for (double& v : channel.values) v = shown += part * (v - shown);
}

// A quarter of a second turns the fastest line by 55 deg and leaves 40 % of it.
TEST(DtgCentrifuge, ALowPassOfTheReferenceIsTakenOut) {
  Trial trial = trial_of(method(), 1);
  smooth(0.25, *std::ranges::find(trial.evidence.recordings[0].channels, "fog.gyro", &Channel::name));
  const Estimate estimate = method().identify(trial.evidence, {});
  EXPECT_NE(finding_of(estimate.findings, "reference_late_on_angles"), nullptr);
  EXPECT_EQ(finding_of(estimate.findings, "reference_sensitive_to_force"), nullptr);
  for (const auto& [name, truth] : trial.truth)
    if (name == "D_x" || name == "D_y" || name == "sensitive_term_5") {
      EXPECT_NEAR(value(estimate, name), truth, 4.0 * sd_of(estimate, name)) << name;
    }
}

TEST(DtgCentrifuge, ALowPassOfTheGyroIsNamed) {
  Trial trial = trial_of(method(), 2);
  smooth(0.25, trial.evidence.recordings[0].channels[0]);
  EXPECT_NE(finding_of(method().identify(trial.evidence, {}).findings, "loop_lag_differs"), nullptr);
}

// 7.5 ms of a program that samples every 50 ms: the second harmonic of the fastest level loses 5 %, and the lag explains 1 % of it.
TEST(DtgCentrifuge, WhatALowPassOfAProgramTakesFromTheAmplitudeIsAnUncertainty) {
  double squares = 0.0;
  constexpr int seeds = 5;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Trial trial = trial_of(method(), seed);
    smooth(0.0075, trial.evidence.recordings[0].channels[0]);
    const Estimate estimate = method().identify(trial.evidence, {});
    const auto truth = std::ranges::find(trial.truth, "D_xx_less_D_yy", [](const auto& one) { return one.first; });
    squares += std::pow((value(estimate, truth->first) - truth->second) / sd_of(estimate, truth->first), 2);
  }
  EXPECT_LT(std::sqrt(squares / seeds), 2.2);
}

// 0.127 deg/h with the arm's field: too little to be named in half of the tests, and 5 sd of K at the first level.
TEST(DtgCentrifuge, ALineThatIsTooLittleToBeNamedIsAnUncertainty) {
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Trial trial = trial_of(method(), seed);
    Recording& recording = trial.evidence.recordings[0];
    const Channel& angle = *find_channel(recording, "table_angle");
    Channel& gyro = recording.channels[0];
    for (std::size_t i = 0; i < gyro.values.size(); ++i) gyro.values[i] += 6.2e-7 * std::cos(angle.values[i]);
    const Estimate estimate = method().identify(trial.evidence, {});
    const double truth =
        std::ranges::find(trial.truth, "sensitive_term_1", [](const auto& one) { return one.first; })->second;
    squares += std::pow((value(estimate, "sensitive_term_1") - truth) / sd_of(estimate, "sensitive_term_1"), 2);
  }
  EXPECT_LT(std::sqrt(squares / 5.0), 2.6);  // chi-square of 5, p = 5e-7
}

TEST(DtgCentrifuge, AnEncoderOfAnotherScaleIsAnError) {
  Evidence evidence = evidence_of(noisy());
  EXPECT_EQ(finding_of(method().identify(evidence, {}).findings, "line_turns_against_angle"), nullptr);
  for (double& angle : evidence.recordings[0].channels[3].values) angle *= 1.0 + 1e-4;
  EXPECT_NE(finding_of(method().identify(evidence, {}).findings, "line_turns_against_angle"), nullptr);
}

TEST(DtgCentrifuge, ExchangedGyrosAreAnError) {
  Evidence evidence = evidence_of(noisy());
  EXPECT_EQ(finding_of(method().identify(evidence, {}).findings, "gyro_and_reference_exchanged"), nullptr);
  std::swap(evidence.recordings[0].channels[0].values, evidence.recordings[0].channels[1].values);
  EXPECT_NE(finding_of(method().identify(evidence, {}).findings, "gyro_and_reference_exchanged"), nullptr);
}

TEST(DtgCentrifuge, ALevelThatIsMissingKeepsItsNumber) {
  Evidence evidence = evidence_of(noisy());
  const double third = value(method().identify(evidence, {}), "sensitive_term_3");
  std::erase_if(evidence.recordings[0].marks, [](const Mark& mark) { return mark.label == "spin 2"; });
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_EQ(find_parameter(estimate, "sensitive_term_2"), nullptr);
  EXPECT_NEAR(value(estimate, "sensitive_term_3"), third, 1e-3 * third);
  EXPECT_NE(finding_of(estimate.findings, "not_recorded"), nullptr);
}

// The end of each segment then has 0.3 s at the rate of the next.
TEST(DtgCentrifuge, LevelsWhoseMarksAreLateAreCutToEvenTurning) {
  Evidence evidence = evidence_of(noisy());
  const Estimate sound = method().identify(evidence, {});
  EXPECT_EQ(finding_of(sound.findings, "levels_cut_to_even_turning"), nullptr);
  for (std::size_t m = 1; m < evidence.recordings[0].marks.size(); ++m) evidence.recordings[0].marks[m].begin += 0.3;
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_NE(finding_of(estimate.findings, "levels_cut_to_even_turning"), nullptr);
  EXPECT_NEAR(value(estimate, "D_x"), value(sound, "D_x"), 4.0 * sd_of(sound, "D_x"));
  EXPECT_NEAR(value(estimate, "sensitive_term_1"), value(sound, "sensitive_term_1"),
              4.0 * sd_of(sound, "sensitive_term_1"));
}

// One level of five is 1 % larger than the polynomial of the others: 0.07 deg/h/g, which the noise shows 40 times over.
TEST(DtgCentrifuge, ALevelOffThePolynomialOfTheOthersIsAnError) {
  Synthetic s = five_levels();
  s.length = 60.0;
  s.sd = si(0.5, "deg/h");
  Evidence evidence = evidence_of(s);
  EXPECT_FALSE(has_finding(method().identify(evidence, {}).findings, "levels_off_polynomial"));
  auto& recording = evidence.recordings[0];
  for (std::size_t i = 0; i < recording.channels[0].values.size(); ++i) {
    const double t = recording.channels[0].time(i);
    if (t >= recording.marks[3].begin && t < recording.marks[4].begin) recording.channels[0].values[i] *= 1.01;
  }
  const auto findings = method().identify(evidence, {}).findings;
  EXPECT_TRUE(has_error(findings, "levels_off_polynomial"));
  EXPECT_EQ(text_of(findings, "levels_off_polynomial", "level"), recording.marks[3].label);
}

// Two levels cannot show the lag: it is in the budget. K does not depend on it.
TEST(DtgCentrifuge, ALagThatTheLevelsCannotShowIsInTheBudget) {
  Synthetic s = tilted();
  s.arm_rates = {160, 359};
  s.length = 60.0;
  s.lag = 0.02;
  s.loop_stated = false;
  s.sd = si(0.5, "deg/h");
  const Estimate estimate = method().identify(evidence_of(s), {});
  EXPECT_NE(finding_of(estimate.findings, "loop_lag_unknown"), nullptr);
  EXPECT_EQ(find_parameter(estimate, "loop_lag"), nullptr);
  for (const auto& [name, truth] : {std::pair{"D_x", 6.15}, {"D_y", -2.55}})
    EXPECT_NEAR(value(estimate, name), si(truth, "deg/h/g"), 3.0 * sd_of(estimate, name)) << name;
  EXPECT_NEAR(K(estimate, 2), std::hypot(6.15, 2.55), 4.0 * sd_of(estimate, "sensitive_term_2") / si(1.0, "deg/h/g"));
}

TEST(DtgCentrifuge, AReversedGyroIsAnError) {
  Synthetic s = five_levels();
  s.length = 60.0;
  EXPECT_EQ(finding_of(method().identify(evidence_of(s), {}).findings, "gyro_reversed"), nullptr);
  s.sign = -1.0;
  const Estimate reversed = method().identify(evidence_of(s), {});
  const Finding* finding = finding_of(reversed.findings, "gyro_reversed");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->severity, Finding::Severity::error);
  s.sign = 1.0;
  s.azimuth = si(90.0, "deg");
  EXPECT_NE(finding_of(method().identify(evidence_of(s), {}).findings, "gyro_axis_is_another"), nullptr);
  Evidence stated = evidence_of(s);
  stated.plan.settings.set_number("reference_azimuth", si(90.0, "deg"), Unit::parse("deg"));
  EXPECT_EQ(finding_of(method().identify(stated, {}).findings, "gyro_axis_is_another"), nullptr);
  s.azimuth = 0.0;
  s.gain = 1.5;
  EXPECT_NE(finding_of(method().identify(evidence_of(s), {}).findings, "gyro_gain_far_from_stated"), nullptr);
}

// Steps of 5 deg/h, where the line of the first level has 7 deg/h and that of the fifth 128: the crests of all stay in
// one step for many samples. Cut at 80 % of the crest it is clipped.
TEST(DtgCentrifuge, ACoarseOutputIsNotClipped) {
  Synthetic s = five_levels();
  s.length = 60.0;
  s.offset = si(1.0, "deg/h");
  Evidence evidence = evidence_of(s);
  const double step = si(5.0, "deg/h");
  for (const std::size_t c : {0u, 1u})
    for (double& v : evidence.recordings[0].channels[c].values) v = step * std::round(v / step);
  const Estimate coarse = method().identify(evidence, {});
  EXPECT_EQ(finding_of(coarse.findings, "channel_clipped"), nullptr);
  EXPECT_NEAR(K(coarse, 5), 6.881, 0.05);
  for (double& v : evidence.recordings[0].channels[0].values) v = std::min(v, 20.0 * step);
  EXPECT_NE(finding_of(method().identify(evidence, {}).findings, "channel_clipped"), nullptr);
}

TEST(DtgCentrifuge, ErrorsOfTheRigHaveTheKeyOfTheEquipment) {
  Trial trial = trial_of(method(), 1);
  trial.evidence.plan.rig_equipment = "C-77, certificate 2031";
  const Estimate estimate = method().identify(trial.evidence, {});
  const auto line = [&](const char* source) {
    return std::ranges::find(estimate.budget, source, &Contribution::source)->key;
  };
  EXPECT_EQ(line("radius"), "C-77, certificate 2031");
  EXPECT_EQ(line("wobble of table twice per turn, cosine"), "C-77, certificate 2031");
  EXPECT_EQ(line("output noise"), "");
}

TEST(DtgCentrifuge, OutputYIsIdentifiedToo) {
  Plan plan = trial_of(method(), 1).evidence.plan;
  set_truth(plan, "y_D_x", 2.0, "deg/h/g");
  set_truth(plan, "y_D_y", 5.0, "deg/h/g");
  set_truth(plan, "y_D_yyy", 6e-4, "deg/h/g^3");
  plan.rig.set_flag("ideal", true);
  Evidence evidence{plan, {simulate(plan, 3, {})}};
  const Estimate estimate = method().identify(evidence, {});
  for (const auto& [name, truth] : {std::pair{"y_D_x", 2.0}, {"y_D_y", 5.0}}) {
    const Parameter* p = find_parameter(estimate, name);
    ASSERT_NE(p, nullptr);
    const double sd = standard_uncertainty(estimate, static_cast<std::size_t>(p - estimate.parameters.data()));
    EXPECT_NEAR(p->value, si(truth, "deg/h/g"), 4.0 * sd) << name;
    EXPECT_LT(sd, si(0.1, "deg/h/g"));
  }
}

TEST(DtgCentrifuge, CompensationSubtractsTheDrift) {
  Synthetic s = five_levels();
  s.length = 60.0;
  const Estimate estimate = method().identify(evidence_of(s), {});
  Recording use = evidence_of(s).recordings.front();
  for (const char* axis : {"x", "y", "z"})
    use.channels.push_back({std::string("specific_force_") + axis,
                            QuantityKind::specific_force,
                            Unit::parse("g"),
                            use.channels[0].timeline,
                            {}});
  const Channel &arm = use.channels[2], &table = use.channels[3];
  for (std::size_t i = 0; i < arm.values.size(); ++i) {
    const double w = i + 1 < arm.values.size() && arm.values[i + 1] > arm.values[i]
                         ? (arm.values[i + 1] - arm.values[i]) * s.rate
                         : (i > 0 && arm.values[i] > 0.0 ? (arm.values[i] - arm.values[i - 1]) * s.rate : 0.0);
    const double a = w * w * radius, theta = -table.values[i];
    use.channels[4].values.push_back(-a * std::cos(theta));
    use.channels[5].values.push_back(-a * std::sin(theta));
    use.channels[6].values.push_back(g);
  }
  const Compensation out = compensate(estimate, use, nullptr);
  for (const Finding& finding : out.findings) EXPECT_EQ(finding.code, "even_drift_terms_remain");
  Estimate quintic = estimate;  // f_X a^4 at 5 g
  for (auto& p : quintic.parameters)
    if (p.name == "p_4") p.value += si(1e-5, "deg/h/g^5");
  const std::size_t at = 15000;
  const double fx = use.channels[4].values[at] / g, fy = use.channels[5].values[at] / g;
  EXPECT_NEAR(out.recording.channels[0].values[at] - compensate(quintic, use, nullptr).recording.channels[0].values[at],
              si(1e-5, "deg/h") * fx * std::pow(fx * fx + fy * fy, 2), si(1e-6, "deg/h"));
  // the Earth's rate and D_F remain
  for (const std::size_t i : {3000u, 15000u, 30000u})
    EXPECT_NEAR(out.recording.channels[0].values[i],
                earth * std::cos(arm.values[i] + table.values[i]) + si(4.0, "deg/h"), si(1e-6, "deg/h"));
  for (double& f : use.channels[4].values) f *= 1.5;
  EXPECT_NE(finding_of(compensate(estimate, use, nullptr).findings, "extrapolated"), nullptr);
  use.channels.resize(5);  // along x alone
  EXPECT_NE(finding_of(compensate(estimate, use, nullptr).findings, "terms_remain"), nullptr);
  use.channels.resize(4);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "every term of the error model"},
                      [&] { compensate(estimate, use, nullptr); }));
}

// The root of a difference of variances with four power-ups: its interval reaches further to the large side, and does
// not begin below zero as value -+ t sd does with seed 40, where the power-ups are alike.
TEST(DtgCentrifuge, TheIntervalOfTheRepeatabilityStaysAboveZero) {
  for (const std::uint64_t seed : {1, 2, 3, 40}) {
    const Estimate estimate = method().identify(trial_of(method(), seed).evidence, {});
    const Parameter* repeatability = find_parameter(estimate, "turn_on_repeatability");
    ASSERT_NE(repeatability, nullptr) << seed;
    const auto index = static_cast<std::size_t>(repeatability - estimate.parameters.data());
    const double lower = repeatability->lower, upper = repeatability->upper;
    EXPECT_GT(lower, 0.0) << seed;
    EXPECT_LT(lower, repeatability->value) << seed;
    EXPECT_GT(upper - repeatability->value, repeatability->value - lower) << seed;
    if (seed != 40) continue;
    const double sd = standard_uncertainty(estimate, index);
    EXPECT_LT(repeatability->value - student_quantile(0.975, repeatability->degrees_of_freedom) * sd, 0.0);
  }
}

}  // namespace
}  // namespace tumble::dtg_centrifuge_test
