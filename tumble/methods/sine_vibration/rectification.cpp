#include "tumble/methods/sine_vibration/rectification.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/reduce/linear/slow.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::sine_vibration {
namespace {

using Severity = Finding::Severity;
constexpr double two_levels = 1.5;  ///< ratio of the highest to the lowest level, with which shift and level are fitted
constexpr double least_own_scatter = 1e-6;  ///< [1] of the scatter of blocks that rounding does not explain

constexpr double same_way = 0.02 * standard_gravity;  ///< [m/s^2] of a_0

/// One segment of the model: a point, or the unit at rest.
struct Part {
  std::size_t series = 0;
  const Line* line = nullptr;
  const Point* point = nullptr;
};

std::vector<Part> parts_of(const vibration::Data& data, const Measured& measured, std::size_t unit) {
  std::vector<Part> parts;
  for (const auto& rest : measured.rests)
    if (data.series[rest.series].unit == unit) parts.push_back({rest.series, &rest.line, nullptr});
  for (const auto& point : measured.points)
    if (point.unit == unit && !std::isnan(point.shift)) parts.push_back({point.series, &point.line, &point});
  std::ranges::sort(parts, {}, &Part::series);  // as Data::series: in order of time
  return parts;
}

bool alike(double a, double b) { return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) < same_way; }

/// Power-ups, each in each way its fixture stood: an offset each.
struct Groups {
  std::vector<std::size_t> of_part;
  std::vector<double> middle, half;  ///< [s] of the time each takes
  std::vector<std::size_t> rests;    ///< segments at rest
};

Groups groups_of(const vibration::Data& data, const std::vector<Part>& parts) {
  Groups groups;
  std::vector<const vibration::Series*> first;
  std::vector<double> begin, end;
  for (const Part& part : parts) {
    const auto& series = data.series[part.series];
    std::size_t g = 0;
    while (g < first.size() && !(first[g]->power_up == series.power_up && alike(first[g]->rest, series.rest))) ++g;
    if (g == first.size()) {
      first.push_back(&series);
      begin.push_back(series.begin);
      end.push_back(series.end);
      groups.rests.push_back(0);
    }
    end[g] = std::max(end[g], series.end);
    groups.rests[g] += part.point == nullptr ? 1 : 0;
    groups.of_part.push_back(g);
  }
  for (std::size_t g = 0; g < first.size(); ++g) {
    groups.middle.push_back(0.5 * (begin[g] + end[g]));
    groups.half.push_back(0.5 * (end[g] - begin[g]));
  }
  return groups;
}

std::vector<Rectification::Way> ways_of(const vibration::Data& data, const std::vector<Part>& parts) {
  std::vector<Rectification::Way> ways;
  for (const Part& part : parts) {
    const double rest = data.series[part.series].rest;
    if (part.point != nullptr && std::ranges::none_of(ways, [&](const auto& way) { return alike(way.rest, rest); }))
      ways.push_back({rest, ways.size()});
  }
  std::ranges::sort(ways, [](const auto& a, const auto& b) { return a.rest > b.rest; });
  for (std::size_t w = 0; w < ways.size(); ++w) ways[w].column = w;
  return ways;
}

/// Levels of which one is 1.5 times another at least separate A^4 from A^2.
bool has_levels(const std::vector<Part>& parts) {
  double low = INFINITY, high = 0.0;
  for (const Part& part : parts) {
    if (part.point == nullptr) continue;
    low = std::min(low, part.point->level);
    high = std::max(high, part.point->level);
  }
  return high > two_levels * low;
}

struct Rows {
  MixedData data;
  std::vector<double> rounding;  ///< sd of the mean of each part [m/s^2]
};

/// Blocks about their means, drawn together by the share of rounding in their scatter: rounding does not add up, and
/// enters as a source of its own.
void add_rows(const vibration::Data& data, const std::vector<Part>& parts, const Rectification& r, const Groups& groups,
              const std::vector<std::size_t>& drift_column, std::size_t columns, Rows& rows) {
  const double pulse = data.units[r.unit].pulse;
  double scatter = 0.0, rounded = 0.0;
  for (const Part& part : parts)
    for (std::size_t b = 0; b < part.line->block_mean.size(); ++b) {
      const double seconds = part.line->block_seconds[b];
      scatter += seconds * std::pow(part.line->block_mean[b] - part.line->mean, 2);
      rounded += seconds * pulses::rounding_variance(pulse, seconds);
    }
  const double shrinking = scatter > 0.0 ? std::sqrt(std::max(least_own_scatter, 1.0 - rounded / scatter)) : 1.0;
  std::size_t n = 0;
  for (const Part& part : parts) n += part.line->block_mean.size();
  MixedData& m = rows.data;
  m.design = Matrix(n, columns);
  std::size_t i = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const auto& series = data.series[parts[p].series];
    const Line& line = *parts[p].line;
    const std::size_t g = groups.of_part[p];
    const double sd = std::sqrt(pulses::rounding_variance(pulse, static_cast<double>(line.samples) * series.window));
    for (std::size_t b = 0; b < line.block_mean.size(); ++b, ++i) {
      m.observations.push_back(line.mean + shrinking * (line.block_mean[b] - line.mean));
      m.weights.push_back(line.block_seconds[b]);
      m.segment.push_back(p);
      rows.rounding.push_back(sd);
      m.design(i, r.ways.size() + (r.quartic ? 1 : 0) + g) = 1.0;
      if (drift_column[g] > 0) m.design(i, drift_column[g]) = (series.middle() - groups.middle[g]) / groups.half[g];
      if (parts[p].point == nullptr) continue;
      const double a = parts[p].point->level;
      for (const auto& way : r.ways)
        if (alike(way.rest, series.rest)) m.design(i, way.column) = 0.5 * a * a;
      if (r.quartic) m.design(i, r.quartic_column) = a * a * a * a;
    }
  }
}

/// A share of K_2,eff for each frequency: A_a^2/2 A_b^2/2 between parts of one frequency.
Matrix between_kernel(const std::vector<Part>& parts) {
  Matrix kernel(parts.size(), parts.size());
  for (std::size_t a = 0; a < parts.size(); ++a)
    for (std::size_t b = 0; b < parts.size(); ++b) {
      const Point *x = parts[a].point, *y = parts[b].point;
      if (x == nullptr || y == nullptr || x->nominal != y->nominal) continue;
      kernel(a, b) = 0.25 * x->level * x->level * y->level * y->level;
    }
  return kernel;
}

void add_noise(const vibration::Data& data, const std::vector<Part>& parts, std::size_t columns, bool between,
               Rows& rows) {
  std::vector<linear::Interval> intervals;
  for (const Part& part : parts) {
    const auto& series = data.series[part.series];
    intervals.push_back({series.power_up, series.begin, series.end - series.begin});
  }
  // Offsets of the power-ups are columns: the bias of each is no noise.
  for (auto& slow : linear::unknown_slow_noise(intervals, columns, data.series[parts.front().series].interval))
    if (slow.source == linear::drift_source) rows.data.slow.push_back({"drift between segments", slow.kernel});
  if (between) rows.data.slow.push_back({"differences between frequencies", between_kernel(parts)});
  if (std::ranges::any_of(rows.rounding, [](double sd) { return sd > 0.0; }))
    rows.data.effects.push_back({"rounding to whole pulses", rows.rounding, true});
}

/// Var of Point::shift: white noise and rounding of the segment and of those at rest, slow noise of all with their
/// covariances.
std::map<std::size_t, double> shift_variances(const vibration::Data& data, const std::vector<Part>& parts,
                                              const Rows& rows, const MixedFit& fit, std::size_t slow_terms) {
  std::vector<double> seconds(parts.size(), 0.0), rounding(parts.size(), 0.0);
  for (std::size_t i = 0; i < rows.rounding.size(); ++i) {
    seconds[rows.data.segment[i]] += rows.data.weights[i];
    rounding[rows.data.segment[i]] = rows.rounding[i];
  }
  std::map<std::size_t, double> variances;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].point == nullptr) continue;
    std::vector<double> weight(parts.size(), 0.0);
    weight[p] = 1.0;
    for (const auto& rest : vibration::at_rest(data, data.series[parts[p].series]).parts)
      for (std::size_t q = 0; q < parts.size(); ++q)
        if (parts[q].series == rest.series) weight[q] -= rest.weight;
    double variance = 0.0;
    for (std::size_t a = 0; a < parts.size(); ++a) {
      if (weight[a] == 0.0) continue;
      variance += weight[a] * weight[a] * (fit.white_variance / seconds[a] + rounding[a] * rounding[a]);
      for (std::size_t b = 0; b < parts.size(); ++b)
        for (std::size_t c = 0; c < slow_terms; ++c)
          variance += weight[a] * weight[b] * fit.slow_variance[c] * rows.data.slow[c].kernel(a, b);
    }
    variances[parts[p].series] = variance;
  }
  return variances;
}

std::map<std::size_t, double> fitted_shifts(const vibration::Data& data, const std::vector<Part>& parts,
                                            const Rectification& r) {
  std::map<std::size_t, double> shifts;
  for (const Part& part : parts) {
    if (part.point == nullptr) continue;
    const double a = part.point->level;
    double& shift = shifts[part.series];
    for (const auto& way : r.ways)
      if (alike(way.rest, data.series[part.series].rest)) shift += 0.5 * a * a * r.fit.parameters[way.column];
    if (r.quartic) shift += a * a * a * a * r.fit.parameters[r.quartic_column];
  }
  return shifts;
}

/// Mean variance of the segments about their mean.
double about_their_mean(const Matrix& kernel) {
  const double n = static_cast<double>(kernel.rows);
  double own = 0.0, all = 0.0;
  for (std::size_t a = 0; a < kernel.rows; ++a) {
    own += kernel(a, a) / n;
    for (std::size_t b = 0; b < kernel.rows; ++b) all += kernel(a, b) / (n * n);
  }
  return std::max(0.0, own - all);
}

Rectification rectification_of(const vibration::Data& data, const std::vector<Part>& parts, std::size_t unit,
                               const std::string& levels) {
  Rectification r;
  r.unit = unit;
  r.ways = ways_of(data, parts);
  r.quartic = levels == "quartic" || (levels == "auto" && has_levels(parts));
  r.quartic_column = r.ways.size();
  const Groups groups = groups_of(data, parts);
  std::size_t columns = r.ways.size() + (r.quartic ? 1 : 0) + groups.rests.size(), rests = 0;
  std::vector<std::size_t> drift_column;
  for (const std::size_t n : groups.rests) {
    rests += n;
    drift_column.push_back(n >= 3 ? columns++ : 0);
  }
  Rows rows;
  add_rows(data, parts, r, groups, drift_column, columns, rows);
  // Few segments at rest cannot separate a share of each frequency from noise of each segment.
  const bool between = rests >= 4 && parts.size() - rests >= 4;
  add_noise(data, parts, columns, between, rows);
  r.fit = fit_mixed_model(rows.data);
  const std::size_t slow_terms = rows.data.slow.size() - (between ? 1 : 0);
  for (std::size_t c = 0; c < slow_terms; ++c)
    r.slow_sd += r.fit.slow_variance[c] * about_their_mean(rows.data.slow[c].kernel);
  r.slow_sd = std::sqrt(r.slow_sd);
  if (between) r.between_sd = std::sqrt(r.fit.slow_variance.back());
  r.fitted_shift = fitted_shifts(data, parts, r);
  r.shift_variance = shift_variances(data, parts, rows, r.fit, slow_terms);
  return r;
}

}  // namespace

std::vector<Rectification> rectify(const vibration::Data& data, const Measured& measured, const std::string& levels,
                                   Findings& findings) {
  std::vector<Rectification> rectified;
  for (std::size_t unit = 0; unit < data.units.size(); ++unit) {
    const auto points = std::ranges::count(measured.points, unit, &Point::unit);
    if (points == 0) continue;
    const auto parts = parts_of(data, measured, unit);
    const auto shaken = std::ranges::count_if(parts, [](const Part& part) { return part.point != nullptr; });
    const std::string where = data.units[unit].prefix.empty() ? "" : data.units[unit].name;
    if (shaken < points)
      findings.push_back(
          {Severity::error, "tone_without_rest", {}, where, {static_cast<std::size_t>(points - shaken)}});
    if (shaken == 0) continue;
    try {
      rectified.push_back(rectification_of(data, parts, unit, levels));
    } catch (const Error& error) {
      if (error.kind != Error::Kind::bad_data) throw;
      findings.push_back({Severity::error, "no_rectification", {{"reason", reason_of(error)}}, where});
    }
  }
  return rectified;
}

}  // namespace tumble::sine_vibration
