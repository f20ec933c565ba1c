#include <algorithm>
#include <cmath>

#include "tumble/methods/method.hpp"
#include "tumble/methods/north_finding/report.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/table/recorded_angles.hpp"

// Symbols: i index angle, counter-clockwise seen from above; W_k rate at index angle k; A azimuth, w_ie Earth's rate,
// phi latitude.

namespace tumble::north_finding {
namespace {

std::vector<Role> roles() {
  return {{"gyro", "", true, "output of the gyro along x: a rate, angle increments, counts, a current or a voltage"},
          {"accelerometer_x", "", false,
           "output of the accelerometer along x; absent: the base is as level as the rig says"},
          {"accelerometer_y", "", false, "output of the accelerometer along y"},
          {"table_angle", "deg", false, "recorded angle of a rate table; absent: as commanded"},
          {"outer_angle", "deg", false, "recorded angle of the outer axis of a table of several axes"},
          {"inner_angle", "deg", false, "recorded angle of its inner axis"}};
}

std::vector<Option> options() {
  std::vector<Option> all = instrument_options();
  const std::vector<Option> more{
      linear::bias_instability_option("deg/h", "gyro_"),
      linear::bias_instability_option("ug", "accelerometer_"),
      word("drift", {"auto", "yes", "no"})
          .otherwise("auto")
          .says("whether a linear drift of the bias is part of the model; auto: where six or more positions "
                "distinguish it "
                "from the azimuth"),
      quantity("azimuth_about", "deg")
          .says("rough azimuth, which selects one of the two solutions that two positions have"),
      quantity("reference_azimuth", "deg").says("azimuth known from elsewhere, from which the errors are calculated"),
      quantity("angle_tolerance", "deg")
          .above(0)
          .otherwise("0.1 deg")
          .says("difference between a recorded angle and the plan that is accepted without a warning"),
      quantity("settling", "s")
          .at_least(0)
          .otherwise("2 s")
          .says("time that is skipped in each segment after the rig has settled"),
      quantity("averaging", "s")
          .above(0)
          .otherwise("10 s")
          .says(
              "length of the averages whose scatter gives the noise; at most a tenth of a turn where the table turns")};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

Reduction reduced(const Bench& bench, Instrument instrument, bool predicted) {
  Reduction out{std::move(instrument), {}, {}, {}};
  out.setup = (predicted ? set_up_prediction : set_up)(bench, out.instrument);
  if (contains(out.setup.free, gyro_z)) forget(out.instrument, gyro_z);  // the turns show it
  const auto errors = disturbances_of(bench, contains(out.setup.free, pitch), contains(out.setup.free, roll));
  for (std::size_t c = 0; c < bench.signals.size(); ++c)
    out.noise.push_back(predicted ? expected_noise(bench, c, out.setup.start)
                                  : noise_of(bench, c, out.setup.start, errors, out.setup.drift));
  out.solution = solve(bench, out.instrument, out.setup, out.noise, errors, predicted);
  return out;
}

Estimate answer(const Bench& bench, bool predicted) {
  const Plan& plan = *bench.plan;
  if (!plan.calibration.result)
    return described(bench, reduced(bench, nominal_instrument(plan, bench.records), predicted), nullptr, predicted);
  const Reduction identified = reduced(bench, identified_instrument(plan, bench.records), predicted);
  const Reduction nominal = reduced(bench, nominal_instrument(plan, bench.records), predicted);
  return described(bench, identified, &nominal, predicted);
}

/// Recorded angles. A table that went to another angle than the plan says came to rest at another time as well: the
/// readings are then evaluated a second time, with the angles of the first.
table::RecordedAngles recorded_angles(const Evidence& evidence, double settling, double tolerance) {
  auto first = table::with_recorded_angles(evidence, settling, tolerance);
  if (std::ranges::none_of(first.stands, [&](const table::Stand& stand) {
        return std::abs(stand.recorded - stand.commanded) > tolerance;
      }))
    return first;
  auto second = table::with_recorded_angles(first.evidence, settling, tolerance);
  for (std::size_t k = 0; k < second.stands.size(); ++k) second.stands[k].commanded = first.stands[k].commanded;
  second.findings = first.findings;
  return second;
}

/// A gyro that misses the horizontal rate: whether a channel of the same kind, to which the plan gives no role, shows it.
Findings about_other_gyros(const Evidence& evidence, const Bench& bench) {
  const Plan& plan = *bench.plan;
  const Reduction reduction = reduced(
      bench,
      plan.calibration.result ? identified_instrument(plan, bench.records) : nominal_instrument(plan, bench.records),
      false);
  const tumble::Channel& gyro = require_channel(evidence, evidence.recordings.front(), "gyro");
  for (const tumble::Channel& other : evidence.recordings.front().channels) {
    if (other.name == gyro.name || other.kind != gyro.kind || other.unit.dimension() != gyro.unit.dimension()) continue;
    Evidence with_other = evidence;
    with_other.plan.channels["gyro"] = {{other.name, std::nullopt}};
    try {
      if (const auto finding = shown_by_another(bench, reduction, bench_of(with_other), other.name)) return {*finding};
    } catch (const Error&) {  // a channel that cannot be reduced is no gyro of this test
    }
  }
  return {};
}

Estimate identify(const Evidence& evidence, const Progress&) {
  const auto& settings = evidence.plan.settings;
  const double tolerance = settings.number("angle_tolerance");
  const auto angles = recorded_angles(evidence, settings.number("settling"), tolerance);
  const Bench bench = bench_of(angles.evidence);
  Estimate estimate = answer(bench, false);
  if (std::ranges::find(estimate.findings, "wrong_horizontal_rate", &Finding::code) != estimate.findings.end())
    for (auto& finding : about_other_gyros(angles.evidence, bench)) estimate.findings.push_back(std::move(finding));
  estimate.findings.insert(estimate.findings.end(), angles.findings.begin(), angles.findings.end());
  if (!angles.stands.empty()) estimate.tables.push_back(table::angles_table(angles));
  return estimate;
}

Estimate predict(const Plan& plan) { return answer(bench_of(plan), true); }

}  // namespace

extern const Method north_finding{
    .name = "north_finding",
    .summary = "azimuth from a gyro at index angles about the vertical: two, four, many positions or turning, any tilt",
    .source =
        "CN113175941B (Xi'an University of Technology, 2023): north finder with a ring laser gyro and two "
        "accelerometers; the search for north is derived",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .predict = predict,
    .takes_calibration = true};

}  // namespace tumble::north_finding
