#include <algorithm>
#include <cmath>

#include "tumble/methods/frequency_response/describe.hpp"
#include "tumble/methods/frequency_response/phase.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

// H(f) = Y/R, output over reference, each the complex amplitude of a sine fitted in time (tones) or of the spectra over
// a band (sweeps). An output that is the mean over H seconds shows sinc(fH) of it:
//   y_j = a_0 + A sinc(fH) cos(2 pi f t_mid,j + p)          (3.8)
//   |G(f)| = amplitude/(A_ref |sinc(fH)|)                   (3.15)

namespace tumble::frequency_response {
namespace {

constexpr double least_gain = 0.5, most_gain = 2.0;  ///< [1] of an instrument that shows what its reference does
constexpr double least_shift = 1e-9;                 ///< [1] of the gain and [rad], below which a source has no effect

std::vector<Role> roles() {
  return {{"output", "", false,
           "the instrument under test, in any unit; without it 'gyro', 'accelerometer' or the only such channel"},
          {"reference", "", false,
           "the motion that the instrument feels: reference accelerometer, rate or angle of a table (an angle is "
           "differentiated); without it, the motion commanded to the plan's rig"}};
}

std::vector<Option> options() {
  return {
      text("scale_factor")
          .says("output for one unit of the reference where they differ in kind, for example \"1000 pulse/(m/s)\" or "
                "\"0.1 V/g\"; absent: gains relative to the lowest frequency"),
      quantity("averaging", "s")
          .at_least(0)
          .says("time over which a sample of the output is the mean, from its stamp on; absent: one sampling "
                "interval for counts and increments, else 0 s"),
      quantity("reference_averaging", "s")
          .at_least(0)
          .says("time over which a sample of the reference is the mean, from its stamp on; absent: 0 s"),
      word("stamps", {"instant", "begin"})
          .otherwise("instant")
          .says("time of a sample that is not a mean: its stamp, or the middle of the interval that begins there, "
                "as `tumble simulate` writes it"),
      quantity("clock_offset", "s").otherwise("0 s").says("time by which stamps of the output are late"),
      quantity("clock_offset_sd", "s").at_least(0).otherwise("0 s").says("standard uncertainty of clock_offset"),
      quantity("reference_gain_sd", "%")
          .at_least(0)
          .otherwise("0 %")
          .says("standard uncertainty of the reference's scale"),
      quantity("reference_maximum", "Hz").above(0).says("highest frequency at which the reference is calibrated"),
      quantity("settling", "s")
          .at_least(0)
          .says("time to skip where a tone begins; absent: a tenth of the segment, at least two cycles"),
      integer("points_per_decade")
          .between(3, 60)
          .otherwise("10")
          .says("frequencies in a decade at which a sweep is evaluated")};
}

void require_points(const Points& points) {
  if (!points.usable.empty()) return;
  auto problems = errors_among(points.findings);
  if (problems.empty())
    problems.emplace_back("no segment of the schedule oscillates: frequency_response needs sine or sweep segments");
  throw Error(Error::Kind::bad_data, problems);
}

Source noise_source(const std::string& name, const std::vector<Point>& points, bool of_output) {
  const std::size_t n = points.size();
  Source source{name, Matrix(2 * n, 2 * n), std::vector<double>(2 * n)};
  for (std::size_t i = 0; i < n; ++i) {
    const Point& p = points[i];
    source.shifts(i, i) = std::sqrt(of_output ? p.output_gain_variance : p.reference_gain_variance);
    source.shifts(n + i, n + i) = std::sqrt(of_output ? p.output_phase_variance : p.reference_phase_variance);
    source.degrees_of_freedom[i] = source.degrees_of_freedom[n + i] = of_output ? p.output_dof : p.reference_dof;
  }
  return source;
}

/// What repeats show beyond their noise.
Source scatter_source(const std::vector<Point>& points) {
  const std::size_t n = points.size();
  Source source{"scatter of repeats", Matrix(2 * n, 2 * n), std::vector<double>(2 * n)};
  for (std::size_t i = 0; i < n; ++i) {
    source.shifts(i, i) = std::sqrt(points[i].scatter_gain_variance);
    source.shifts(n + i, n + i) = std::sqrt(points[i].scatter_phase_variance);
    source.degrees_of_freedom[i] = points[i].scatter_gain_dof;
    source.degrees_of_freedom[n + i] = points[i].scatter_phase_dof;
  }
  return source;
}

/// Errors that all frequencies share: scale of the reference, clock.
void add_common(const std::vector<Point>& points, const Settings& settings, bool relative,
                std::vector<Source>& sources) {
  const std::size_t n = points.size();
  if (std::ranges::any_of(points, [](const Point& p) { return p.counting_variance > 0.0; })) {
    sources.push_back({"rounding to whole pulses", Matrix(2 * n, 2 * n), {}});
    for (std::size_t i = 0; i < 2 * n; ++i) sources.back().shifts(i, i) = std::sqrt(points[i % n].counting_variance);
  }
  if (const double sd = settings.number("reference_gain_sd"); sd > 0.0 && !relative) {
    sources.push_back({"reference gain", Matrix(2 * n, 1), {}});
    for (std::size_t i = 0; i < n; ++i) sources.back().shifts(i, 0) = sd;
  }
  if (const double sd = settings.number("clock_offset_sd"); sd > 0.0) {
    sources.push_back({"clock offset", Matrix(2 * n, 1), {}});
    for (std::size_t i = 0; i < n; ++i) sources.back().shifts(n + i, 0) = two_pi * points[i].frequency * sd;
  }
}

/// Each error of the rig: move it by one standard deviation, and measure again with the reference that it then gives.
void add_rig(const Evidence& evidence, const std::vector<Point>& points, std::vector<Source>& sources) {
  const Measured nominal = measured_of(points);
  const std::size_t n = points.size();
  for (const auto& error : errors_of_rig(evidence)) {
    Findings unused;
    const Points moved = points_of(data_of(evidence, &error), evidence.plan.settings, {});
    const auto others = combined(moved.usable, unused);
    if (others.size() != n) continue;
    const Measured there = measured_of(others);
    const bool each = error.error.each_segment;
    Source source{error.error.name, Matrix(2 * n, each ? 2 * n : 1), {}};
    double greatest = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double gain = there.log_gain[i] - nominal.log_gain[i], phase = there.phase[i] - nominal.phase[i];
      source.shifts(i, each ? i : 0) = gain;
      source.shifts(n + i, each ? n + i : 0) = phase;
      greatest = std::max({greatest, std::abs(gain), std::abs(phase)});
    }
    if (greatest > least_shift) sources.push_back(std::move(source));
  }
}

/// A finding where the gain of the lowest frequency is far above one, or that of all frequencies far below: a wrong unit.
void check_gain(const std::vector<Point>& points, Findings& findings) {
  double greatest = 0.0;
  for (const Point& point : points) greatest = std::max(greatest, std::abs(point.response));
  const double lowest = std::abs(points.front().response), gain = greatest < least_gain ? greatest : lowest;
  if (gain >= least_gain && lowest <= most_gain) return;
  findings.push_back(
      {Finding::Severity::warning, "improbable_gain", {{"gain", gain}, {"motion", Phrase{"motion_of_reference"}}}});
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Settings& settings = evidence.plan.settings;
  const Data data = data_of(evidence, nullptr);
  Points points = points_of(data, settings, progress);
  require_points(points);
  Findings findings = data.findings;
  findings.insert(findings.end(), points.findings.begin(), points.findings.end());
  const auto means = combined(std::move(points.usable), findings);
  std::vector<Source> sources{noise_source("output noise", means, true)};
  if (data.from_rig)
    add_rig(evidence, means, sources);
  else if (std::ranges::any_of(means, [](const Point& p) { return p.reference_gain_variance > 0.0; }))
    sources.push_back(noise_source("reference noise", means, false));
  if (std::ranges::any_of(
          means, [](const Point& p) { return p.scatter_gain_variance > 0.0 || p.scatter_phase_variance > 0.0; }))
    sources.push_back(scatter_source(means));
  add_common(means, settings, data.scaling.relative, sources);
  if (!data.scaling.relative) check_gain(means, findings);
  if (data.from_rig) findings.push_back({Finding::Severity::info, "reference_from_rig", {}});
  report(progress, 1.0, "done");
  return finished(describe(means, data, sources), findings);
}

}  // namespace

extern const Method frequency_response{
    .name = "frequency_response",
    .summary = "gain and phase over frequency against a reference, bandwidth, natural frequency and damping",
    .source =
        "Lu Hanjie, Liu Yabin, Zhou Qiang, dynamic test of linear accelerometers based on INS pulse counting, 2019, "
        "section 2.3; sine fits of IEEE Std 1057; local polynomial method of Pintelon and Schoukens, 2012",
    .needs_plan = false,
    .roles = roles,
    .options = options,
    .identify = identify};

}  // namespace tumble::frequency_response
