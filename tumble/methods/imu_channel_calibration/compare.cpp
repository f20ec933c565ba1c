#include "tumble/methods/imu_channel_calibration/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "tumble/core/columns.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/square.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/linear/rows.hpp"

namespace tumble::imu_channel_calibration {
namespace {

constexpr std::array<const char*, 3> sets{"", "split.", "whole_minus_split."};

struct Entry {
  std::string name, symbol, unit, description;
};

Entry entry_of(Kind kind, std::size_t axis, std::size_t which) {
  const std::string role = role_of(kind, axis);
  const char letter = letters[axis];
  if (which == 0) return {role + "_bias", fmt::format("nabla_{}", letter), kind == Kind::gyro ? "deg/h" : "mg", "bias"};
  if (which == 1)
    return {role + "_scale_factor_error", fmt::format("dK_{}", letter), "ppm",
            "K_m/K - 1: 1 + dK multiplies the counts"};
  const char other = letters[other_axis(axis, which)];
  return {fmt::format("{}_misalignment_{}", role, other), fmt::format("E_{}{}", letter, other), "arcsec",
          fmt::format("share of the output of channel {} in channel {}", other, letter)};
}

/// Index of a term among the parameters: set after set, kind after kind.
std::size_t place(std::size_t pairs, std::size_t set, std::size_t pair, std::size_t term) {
  return (set * pairs + pair) * terms + term;
}

/// The three parameters of every term (whole, split, difference) from those of the whole unit or of the channels alone.
Matrix gradients_of(std::size_t pairs, std::size_t pair, const std::array<double, 3>& weights) {
  Matrix gradients(3 * pairs * terms, terms);
  for (std::size_t set = 0; set < 3; ++set)
    for (std::size_t i = 0; i < terms; ++i) gradients(place(pairs, set, pair, i), i) = weights[set];
  return gradients;
}

/// Variance of a term of the whole unit, or of a channel alone, by the repeatability of the bias [SI^2].
double from_repeats(const Pair& pair, std::size_t term) {
  return term % per_axis == 0 ? square(pair.repeatability) : 0.0;
}

/// nu = v^2/(v_w^2/nu_w + v_s^2/nu_s) of a difference, with v from the settled covariance without the repeatability.
double freedom_of_difference(const std::vector<Pair>& pairs, std::size_t p, std::size_t term,
                             const Estimate& estimate) {
  const double repeats = from_repeats(pairs[p], term);
  const auto variance = [&](std::size_t set) {
    const std::size_t k = place(pairs.size(), set, p, term);
    return estimate.covariance(k, k) - (set == 2 ? 2.0 : 1.0) * repeats;
  };
  const double of_v = square(variance(0)) / pairs[p].whole.degrees_of_freedom[term] +
                      square(variance(1)) / pairs[p].split.degrees_of_freedom[term];
  return of_v > 0.0 ? std::max(1.0, square(variance(2)) / of_v) : std::numeric_limits<double>::infinity();
}

/// With the repeatability, whose variance has three degrees of freedom (Welch and Satterthwaite).
void set_degrees_of_freedom(const std::vector<Pair>& pairs, Estimate& estimate) {
  constexpr double channels = 3.0;
  for (std::size_t p = 0; p < pairs.size(); ++p)
    for (std::size_t i = 0; i < terms; ++i) {
      const double repeats = from_repeats(pairs[p], i);
      const std::array<double, 3> nu{pairs[p].whole.degrees_of_freedom[i], pairs[p].split.degrees_of_freedom[i],
                                     freedom_of_difference(pairs, p, i, estimate)};
      for (std::size_t set = 0; set < 3; ++set) {
        const std::size_t k = place(pairs.size(), set, p, i);
        const double all = estimate.covariance(k, k), by_repeats = (set == 2 ? 2.0 : 1.0) * repeats;
        const double of_variance = square(all - by_repeats) / nu[set] + square(by_repeats) / channels;
        estimate.parameters[k].degrees_of_freedom = repeats > 0.0 ? std::max(1.0, square(all) / of_variance) : nu[set];
      }
    }
}

/// [sd] of the greatest of three differences, from which on biases are suspected not to repeat: p = 5 %, by the normal distribution.
/// Student's t would ask for 13 sd where the noise is known to one degree of freedom, and a suspicion accuses nobody.
constexpr double suspected_repeats = 2.4;

/// Sets the repeatability of the biases by the differences of the settled parameters; none where no channel is suspected. One that
/// is known poorly says nothing of the others.
void find_repeatability(std::size_t p, std::vector<Pair>& pairs, const Estimate& estimate) {
  constexpr double differences = 3.0;
  double beyond = 0.0, greatest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t k = place(pairs.size(), 2, p, index_of(axis, 0));
    const double squared = square(estimate.parameters[k].value), variance = estimate.covariance(k, k);
    beyond += squared - variance;
    greatest = std::max(greatest, squared / variance);
  }
  if (greatest < square(suspected_repeats)) return;
  pairs[p].repeatability = std::sqrt(std::max(0.0, beyond) / (2.0 * differences));
}

/// The same number in a bias of the whole unit, or of a channel alone, and in its difference.
std::vector<ErrorLine> lines_of_repeats(std::size_t p, const std::vector<Pair>& pairs) {
  const double sd = pairs[p].repeatability;
  Matrix shifts(3 * pairs.size() * terms, 6);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t set = 0; set < 2; ++set) {
      const std::size_t column = 2 * axis + set, term = index_of(axis, 0);
      shifts(place(pairs.size(), set, p, term), column) = sd;
      shifts(place(pairs.size(), 2, p, term), column) = set == 0 ? sd : -sd;
    }
  if (!(sd > 0.0)) return {};
  return {from_shifts("repeatability from power-up to power-up", std::move(shifts))};
}

}  // namespace

void add_parameters(std::vector<Pair>& pairs, Estimate& estimate) {
  estimate.parameters.resize(3 * pairs.size() * terms);
  std::vector<ErrorLine> lines;
  const auto add_lines = [&](const Matrix& gradients, const std::vector<ErrorLine>& of) {
    std::ranges::move(carried(gradients, of), std::back_inserter(lines));
  };
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Pair& pair = pairs[p];
    add_lines(gradients_of(pairs.size(), p, {1.0, 0.0, 1.0}), pair.whole.lines);
    add_lines(gradients_of(pairs.size(), p, {0.0, 1.0, -1.0}), pair.split.lines);
    for (std::size_t set = 0; set < 3; ++set)
      for (std::size_t i = 0; i < terms; ++i) {
        const Entry entry = entry_of(pair.kind, i / per_axis, i % per_axis);
        const double w = pair.whole.value[i], s = pair.split.value[i];
        const char* what[] = {", whole unit", ", channel alone", ", whole unit minus channel alone"};
        estimate.parameters[place(pairs.size(), set, p, i)] = {sets[set] + entry.name, entry.symbol,
                                                               Unit::parse(entry.unit),
                                                               set == 0   ? w
                                                               : set == 1 ? s
                                                                          : w - s,
                                                               entry.description + what[set]};
        estimate.parameters[place(pairs.size(), set, p, i)].channels = {role_of(pair.kind, i / per_axis)};
      }
  }
  settle(estimate, lines);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    find_repeatability(p, pairs, estimate);
    std::ranges::move(lines_of_repeats(p, pairs), std::back_inserter(lines));
  }
  settle(estimate, lines);
  set_degrees_of_freedom(pairs, estimate);
}

namespace {

const char* tolerance_of(Kind kind, std::size_t which) {
  if (which == 1) return "scale_factor_tolerance";
  if (which > 1) return "misalignment_tolerance";
  return kind == Kind::gyro ? "gyro_bias_tolerance" : "bias_tolerance";
}

}  // namespace

void add_agreement(const std::vector<Pair>& pairs, const Settings& settings, Estimate& estimate) {
  const std::size_t all = pairs.size() * terms;
  const double each = 1.0 - 0.5 * (1.0 - exceeded_in_100) / static_cast<double>(all);  // one test in 100 names a term
  std::size_t agreeing = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p)
    for (std::size_t i = 0; i < terms; ++i) {
      const std::size_t index = place(pairs.size(), 2, p, i);
      const auto& parameter = estimate.parameters[index];
      const double sd = std::sqrt(estimate.covariance(index, index) - 2.0 * from_repeats(pairs[p], i));
      const double size = std::abs(parameter.value);
      const double tolerance = settings.number(tolerance_of(pairs[p].kind, i % per_axis));
      if (size <= 2.0 * sd + tolerance) ++agreeing;
      if (size > student_quantile(each, freedom_of_difference(pairs, p, i, estimate)) * sd + tolerance)
        estimate.findings.push_back({Finding::Severity::warning,
                                     "term_differs",
                                     {{"difference", parameter.value, parameter.unit}, {"ratio", size / sd}},
                                     estimate.parameters[place(pairs.size(), 0, p, i)].name});
    }
  estimate.findings.push_back(
      {Finding::Severity::info,
       "terms_agree",
       {{"agreeing", agreeing}, {"terms", all}, {"expected", 0.05 * static_cast<double>(all)}}});
}

namespace {

/// Means of the three channels of one kind in the positions for the check, and the field in them [SI].
struct Checked {
  std::vector<Vector3> output, felt;
};

Checked checked(Kind kind, const Evidence& evidence) {
  Checked out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto role = role_of(kind, axis);
    const Reading reading =
        reading_of(kind, evidence.plan.settings, require_channel(evidence, evidence.recordings.front(), role));
    linear::Problem problem;
    linear::set_options(evidence.plan.settings, problem);
    problem.role = role;
    problem.scale = reading.scale;
    problem.pulse = reading.pulse;
    const auto rows = linear::rows_of(linear::evidence_of(evidence, problem), problem);
    out.output.resize(rows.segments.size());
    out.felt.resize(rows.segments.size());
    for (std::size_t g = 0; g < rows.segments.size(); ++g) {
      out.output[g][axis] = rows.segments[g].measured;
      out.felt[g] = imu::field_of(kind, rows.segments[g].felt);
    }
  }
  return out;
}

/// M y - nabla - field along one axis; without a calibration: y - field.
double residual(const Calibration* c, const Checked& checked, std::size_t g, std::size_t axis) {
  double value = checked.output[g][axis];
  if (c) {
    value *= 1.0 + c->value[index_of(axis, 1)];
    for (const std::size_t which : {2u, 3u})
      value += c->value[index_of(axis, which)] * checked.output[g][other_axis(axis, which)];
    value -= c->value[index_of(axis, 0)];
  }
  return value - checked.felt[g][axis];
}

struct Residuals {
  double rms = 0.0, most = 0.0;
};

Residuals residuals_of(const Calibration* c, const Checked& checked, std::size_t axis) {
  Residuals out;
  for (std::size_t g = 0; g < checked.output.size(); ++g) {
    const double r = residual(c, checked, g, axis);
    out.rms += r * r / static_cast<double>(checked.output.size());
    out.most = std::max(out.most, std::abs(r));
  }
  out.rms = std::sqrt(out.rms);
  return out;
}

/// Residuals of a channel over the number of the position, by the calibration of the whole unit or of the channels
/// alone.
Curve residual_curve(Kind kind, const Calibration& c, const Checked& means, std::size_t axis, const std::string& by) {
  Curve curve{.name = role_of(kind, axis) + ", " + by,
              .figure = std::string("residuals of the ") + (kind == Kind::gyro ? "gyros" : "accelerometers"),
              .x = {"number of the position", Unit()},
              .y = {"residual", Unit::parse(kind == Kind::gyro ? "deg/h" : "ug")},
              .points = true};
  for (std::size_t g = 0; g < means.output.size(); ++g)
    add_point(curve, static_cast<double>(g + 1), residual(&c, means, g, axis));
  return curve;
}

}  // namespace

void add_comparison(const std::vector<Pair>& pairs, const Sorted& sorted, Estimate& estimate) {
  const bool separate = !sorted.check.recordings.empty();
  if (!separate) estimate.findings.push_back({Finding::Severity::info, "no_check_positions", {}});
  struct Row {
    std::string channel;
    std::size_t positions;
    Unit unit;
    Residuals raw, whole, split;
  };
  std::vector<Row> rows;
  for (const auto& pair : pairs) {
    const Evidence evidence = at_rest(separate ? sorted.check : sorted.whole);
    if (evidence.recordings.empty()) continue;
    const Checked means = checked(pair.kind, evidence);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rows.push_back({role_of(pair.kind, axis), means.output.size(),
                      Unit::parse(pair.kind == Kind::gyro ? "deg/h" : "ug"), residuals_of(nullptr, means, axis),
                      residuals_of(&pair.whole, means, axis), residuals_of(&pair.split, means, axis)});
      estimate.curves.push_back(residual_curve(pair.kind, pair.whole, means, axis, "whole unit"));
      estimate.curves.push_back(residual_curve(pair.kind, pair.split, means, axis, "channels alone"));
    }
  }
  estimate.tables.push_back(
      tabulate("comparison",
               separate ? "residuals in the positions for the check after compensation by each calibration"
                        : "residuals in the positions of the whole unit after compensation by each calibration",
               rows,
               {{"channel", &Row::channel},
                {"positions", &Row::positions},
                {"unit", [](const Row& r) { return r.unit.text(); }},
                {"raw_rms", [](const Row& r) { return r.unit.difference_from_si(r.raw.rms); }},
                {"whole_rms", [](const Row& r) { return r.unit.difference_from_si(r.whole.rms); }},
                {"split_rms", [](const Row& r) { return r.unit.difference_from_si(r.split.rms); }},
                {"whole_largest", [](const Row& r) { return r.unit.difference_from_si(r.whole.most); }},
                {"split_largest", [](const Row& r) { return r.unit.difference_from_si(r.split.most); }}}));
}

Table side_by_side(const std::vector<Pair>& pairs, const Estimate& estimate) {
  const auto index = [&](std::size_t row, std::size_t set) {
    return place(pairs.size(), set, row / terms, row % terms);
  };
  const auto unit = [&](std::size_t row) { return estimate.parameters[index(row, 0)].unit.text(); };
  const auto value = [&](std::size_t set) {
    return [&, set](std::size_t row) {
      const Parameter& parameter = estimate.parameters[index(row, set)];
      return parameter.unit.difference_from_si(parameter.value);
    };
  };
  const auto sd = [&](std::size_t set) {
    return [&, set](std::size_t row) {
      const std::size_t i = index(row, set);
      return estimate.parameters[i].unit.difference_from_si(standard_uncertainty(estimate, i));
    };
  };
  return tabulate("terms", "the model (3.4) by the whole unit and by the channels alone", pairs.size() * terms,
                  {{"term", [&](std::size_t row) { return estimate.parameters[index(row, 0)].name; }},
                   {"unit", unit},
                   {"whole", value(0)},
                   {"whole_sd", sd(0)},
                   {"split", value(1)},
                   {"split_sd", sd(1)},
                   {"difference", value(2)},
                   {"difference_sd", sd(2)},
                   {"ratio", [&](std::size_t row) { return value(2)(row) / sd(2)(row); }}});
}

}  // namespace tumble::imu_channel_calibration
