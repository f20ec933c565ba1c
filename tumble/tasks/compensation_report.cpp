#include "tumble/tasks/compensation_report.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "tumble/core/columns.hpp"

namespace tumble {

namespace {

constexpr std::string_view of_uncertainty = ".compensation_sd";
constexpr std::size_t most_blocks = 2000;

/// Mean of the samples [first, last) that are there; NaN where none is.
double mean_of(const std::vector<double>& values, std::size_t first, std::size_t last) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = first; i < last; ++i)
    if (!std::isnan(values[i])) sum += values[i], count += 1.0;
  return sum / count;
}

/// A channel as it was, as it became, and the uncertainty of what was subtracted.
struct Compensated {
  const Channel &before, &after, &sd;
};

/// Calls visit(first, last) for blocks of one length.
template <class Visit>
void each_block(std::size_t samples, Visit visit) {
  const std::size_t length = std::max<std::size_t>(1, (samples + most_blocks - 1) / most_blocks);
  for (std::size_t first = 0; first < samples; first += length) visit(first, std::min(samples, first + length));
}

Curve curve_named(const std::string& name, const std::string& figure, const Channel& channel) {
  return {.name = name, .figure = figure, .x = {"time", Unit::parse("s")}, .y = {channel.name, channel.unit}};
}

std::vector<Curve> curves_of(const Compensated& one) {
  const std::string both = one.after.name + " before and after compensation";
  Curve before = curve_named("before compensation", both, one.before);
  Curve after = curve_named("after compensation", both, one.after);
  Curve difference = curve_named("subtracted", "what was subtracted from " + one.after.name, one.after);
  difference.y.name = "subtracted from " + one.after.name;
  after.band = difference.band = "2 standard uncertainties of what was subtracted";
  each_block(one.after.values.size(), [&](std::size_t first, std::size_t last) {
    const double time = 0.5 * (one.after.time(first) + one.after.time(last - 1));
    const double raw = mean_of(one.before.values, first, last), left = mean_of(one.after.values, first, last),
                 sd = mean_of(one.sd.values, first, last);
    add_point(before, time, raw);
    add_point(after, time, left, 2.0 * sd);
    add_point(difference, time, raw - left, 2.0 * sd);
  });
  // A current that became a specific force has no difference, and axes of its own.
  if (one.before.unit.dimension() != one.after.unit.dimension()) return {after, before};
  return {before, after, difference};
}

}  // namespace

Estimate compensation_report(const Estimate& result, const Recording& before, const Compensation& done) {
  Estimate report;
  report.method = result.method;
  report.title = (before.origin.file.empty() ? "recording" : before.origin.file) + " compensated";
  report.instrument_model = result.instrument_model;
  report.instrument_serial = result.instrument_serial;
  report.findings = done.findings;
  report.tables = done.tables;
  if (!before.origin.file.empty()) report.provenance.inputs.push_back({before.origin.file, sha256_of(before.origin)});
  for (const Channel& sd : done.recording.channels) {
    if (!sd.name.ends_with(of_uncertainty)) continue;
    const auto name = std::string_view(sd.name).substr(0, sd.name.size() - of_uncertainty.size());
    const Channel *was = find_channel(before, name), *is = find_channel(done.recording, name);
    if (was == nullptr || is == nullptr || was->values.size() != is->values.size() ||
        sd.values.size() != is->values.size())
      continue;
    for (auto& curve : curves_of({*was, *is, sd})) report.curves.push_back(std::move(curve));
  }
  return report;
}

}  // namespace tumble
