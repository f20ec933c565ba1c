#include "tumble/methods/imu_channel_calibration/compare.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/reduce/linear/rows.hpp"

namespace tumble::imu_channel_calibration {
namespace {

constexpr std::array<const char*, 3> sets{"", "split.", "whole_minus_split."};

struct Face {
  std::string name, symbol, unit, description;
};

Face face_of(Kind kind, std::size_t axis, std::size_t which) {
  const std::string role = role_of(kind, axis);
  const char letter = letters[axis];
  if (which == 0) return {role + "_bias", fmt::format("nabla_{}", letter), kind == Kind::gyro ? "deg/h" : "mg", "bias"};
  if (which == 1)
    return {role + "_scale_factor_error", fmt::format("dK_{}", letter), "ppm",
            "K_m/K - 1: 1 + dK multiplies the counts"};
  const char other = letters[other_axis(axis, which)];
  return {fmt::format("{}_misalignment_{}", role, other), fmt::format("E_{}{}", letter, other), "arcsec",
          fmt::format("what channel {} takes off channel {}", other, letter)};
}

/// Covariance of (whole, split) by one source: 24 x 24.
Matrix joint(const Pair& pair, const std::string& source, bool shared) {
  Matrix out(2 * terms, 2 * terms);
  const auto find = [&](const Calibration& c) -> const Matrix* {
    const auto found = std::ranges::find(c.sources, source, &SourceCovariance::source);
    return found == c.sources.end() ? nullptr : &found->covariance;
  };
  const Matrix *whole = find(pair.whole), *split = find(pair.split);
  const auto put = [&](const Matrix* c, std::size_t first) {
    for (std::size_t i = 0; c && i < terms; ++i)
      for (std::size_t j = 0; j < terms; ++j) out(first + i, first + j) = (*c)(i, j);
  };
  put(whole, 0);
  put(split, terms);
  if (!shared || !whole || !split) return out;
  // One number moves both: each covariance is a square, with the sign of dK_x as the sense.
  const auto shift = [](const Matrix& c, std::size_t i) {
    const std::size_t k = index_of(0, 1);
    return c(k, k) > 0.0 ? c(i, k) / std::sqrt(c(k, k)) : 0.0;
  };
  for (std::size_t i = 0; i < terms; ++i)
    for (std::size_t j = 0; j < terms; ++j) out(i, terms + j) = out(terms + j, i) = shift(*whole, i) * shift(*split, j);
  return out;
}

std::vector<std::string> sources_of(const std::vector<Pair>& pairs) {
  std::vector<std::string> names;
  for (const auto& pair : pairs)
    for (const auto* calibration : {&pair.whole, &pair.split})
      for (const auto& source : calibration->sources)
        if (std::ranges::find(names, source.source) == names.end()) names.push_back(source.source);
  return names;
}

/// Covariance of the three parameters of terms i and j (whole, split, difference) from that of (whole, split).
double covariance_of(const Matrix& c, std::size_t set_i, std::size_t i, std::size_t set_j, std::size_t j) {
  const double weights[3][2] = {{1.0, 0.0}, {0.0, 1.0}, {1.0, -1.0}};
  double sum = 0.0;
  for (std::size_t a = 0; a < 2; ++a)
    for (std::size_t b = 0; b < 2; ++b) sum += weights[set_i][a] * weights[set_j][b] * c(a * terms + i, b * terms + j);
  return sum;
}

double freedom_of(const Matrix& total, const Pair& pair, std::size_t set, std::size_t i) {
  const double nu_w = pair.whole.degrees_of_freedom[i], nu_s = pair.split.degrees_of_freedom[i];
  if (set == 0) return nu_w;
  if (set == 1) return nu_s;
  const double v_w = total(i, i), v_s = total(terms + i, terms + i), v = covariance_of(total, 2, i, 2, i);
  const double of_v = v_w * v_w / nu_w + v_s * v_s / nu_s;
  return of_v > 0.0 ? std::max(1.0, v * v / of_v) : std::numeric_limits<double>::infinity();
}

/// Where a term stands among the parameters: set after set, kind after kind.
std::size_t place(std::size_t pairs, std::size_t set, std::size_t pair, std::size_t term) {
  return (set * pairs + pair) * terms + term;
}

}  // namespace

void add_parameters(const std::vector<Pair>& pairs, bool same_gravity, Estimate& estimate) {
  const std::size_t n = 3 * pairs.size() * terms;
  estimate.parameters.resize(n);
  estimate.covariance = Matrix(n, n);
  const auto names = sources_of(pairs);
  for (const auto& name : names) estimate.budget.push_back({name, std::vector<double>(n, 0.0)});
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Pair& pair = pairs[p];
    Matrix total(2 * terms, 2 * terms);
    for (std::size_t s = 0; s < names.size(); ++s) {
      const Matrix c = joint(pair, names[s], same_gravity && names[s] == "gravity");
      for (std::size_t k = 0; k < total.values.size(); ++k) total.values[k] += c.values[k];
      for (std::size_t set = 0; set < 3; ++set)
        for (std::size_t i = 0; i < terms; ++i)
          estimate.budget[s].variance[place(pairs.size(), set, p, i)] = std::max(0.0, covariance_of(c, set, i, set, i));
    }
    for (std::size_t set = 0; set < 3; ++set)
      for (std::size_t i = 0; i < terms; ++i) {
        const Face face = face_of(pair.kind, i / per_axis, i % per_axis);
        const double w = pair.whole.value[i], s = pair.split.value[i];
        const std::size_t at = place(pairs.size(), set, p, i);
        const char* what[] = {", whole unit", ", channel alone", ", whole unit minus channel alone"};
        estimate.parameters[at] = {sets[set] + face.name,        face.symbol,
                                   Unit::parse(face.unit),       set == 0 ? w : set == 1 ? s : w - s,
                                   face.description + what[set], freedom_of(total, pair, set, i)};
        for (std::size_t other = 0; other < 3; ++other)
          for (std::size_t j = 0; j < terms; ++j)
            estimate.covariance(at, place(pairs.size(), other, p, j)) = covariance_of(total, set, i, other, j);
      }
  }
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0.0;
    for (const auto& line : estimate.budget) sum += line.variance[i];
    estimate.covariance(i, i) = sum;
  }
}

void add_agreement(const std::vector<Pair>& pairs, const Settings& settings, Estimate& estimate) {
  std::vector<std::string> apart;
  std::size_t all = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p)
    for (std::size_t i = 0; i < terms; ++i) {
      const std::size_t at = place(pairs.size(), 2, p, i), which = i % per_axis;
      const char* name = which == 1                    ? "scale_factor_tolerance"
                         : which > 1                   ? "misalignment_tolerance"
                         : pairs[p].kind == Kind::gyro ? "gyro_bias_tolerance"
                                                       : "bias_tolerance";
      const auto& parameter = estimate.parameters[at];
      const double sd = standard_uncertainty(estimate, at);
      ++all;
      if (std::abs(parameter.value) > 2.0 * sd + settings.number(name))
        apart.push_back(fmt::format("{} by {} ({:.1f} sd)", parameter.name.substr(std::string(sets[2]).size()),
                                    say_difference(parameter.value, parameter.unit), std::abs(parameter.value) / sd));
    }
  if (apart.empty())
    estimate.findings.push_back({Finding::Severity::info,
                                 fmt::format("all {} terms of the channels alone equal those of the whole unit within "
                                             "twice the standard uncertainty of the difference and the tolerances",
                                             all),
                                 ""});
  else
    estimate.findings.push_back(
        {Finding::Severity::warning,
         fmt::format("{} of {} terms differ between whole unit and channels alone by more than twice the standard "
                     "uncertainty and the tolerance: {} (chance alone gives {:.1f})",
                     apart.size(), all, fmt::join(apart, ", "), 0.05 * static_cast<double>(all)),
         ""});
}

namespace {

/// Means of the three channels of one kind in the positions for the check: y [SI], and what was felt.
struct Checked {
  std::vector<std::array<double, 3>> output, felt;
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
    const auto found = linear::evidence_of(evidence, problem);
    const auto rows = linear::rows_of(found, problem);
    out.output.resize(rows.segments.size());
    out.felt.resize(rows.segments.size());
    for (std::size_t g = 0; g < rows.segments.size(); ++g) {
      const Vector3 v = kind == Kind::gyro ? rows.segments[g].felt.rate : rows.segments[g].felt.specific_force;
      out.output[g][axis] = rows.segments[g].measured;
      out.felt[g] = {v.x, v.y, v.z};
    }
  }
  return out;
}

/// M y - nabla - what was felt, along one axis; a null calibration leaves the output as it is.
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

struct Left {
  double rms = 0.0, most = 0.0;
};

Left left_of(const Calibration* c, const Checked& checked, std::size_t axis) {
  Left left;
  for (std::size_t g = 0; g < checked.output.size(); ++g) {
    const double r = residual(c, checked, g, axis);
    left.rms += r * r / static_cast<double>(checked.output.size());
    left.most = std::max(left.most, std::abs(r));
  }
  left.rms = std::sqrt(left.rms);
  return left;
}

}  // namespace

Table comparison(const std::vector<Pair>& pairs, const Sorted& sorted, Findings& findings) {
  const bool apart = !sorted.check.recordings.empty();
  if (!apart)
    findings.push_back({Finding::Severity::info,
                        "no segment is for the check (its label would begin with the setting check): the comparison is "
                        "made in the positions that the whole-unit calibration was fitted to, which favours it",
                        ""});
  Table table{"comparison",
              apart ? "what is left in the positions for the check after compensation by either calibration"
                    : "what is left in the positions of the whole unit after compensation by either calibration",
              {},
              {}};
  const Unit one, ug = Unit::parse("ug"), rate = Unit::parse("deg/h");
  table.columns = {{"channel", one}, {"positions", one}, {"unit", one}};
  for (const char* name : {"raw_rms", "whole_rms", "split_rms", "whole_largest", "split_largest"})
    table.columns.push_back({name, one});
  for (const auto& pair : pairs) {
    const Evidence evidence = at_rest(apart ? sorted.check : sorted.whole);
    if (evidence.recordings.empty()) continue;
    const Checked seen = checked(pair.kind, evidence);
    const Unit& unit = pair.kind == Kind::gyro ? rate : ug;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Left raw = left_of(nullptr, seen, axis), whole = left_of(&pair.whole, seen, axis),
                 split = left_of(&pair.split, seen, axis);
      const auto shown = [&](double v) { return unit.difference_from_si(v); };
      table.rows.push_back({role_of(pair.kind, axis), static_cast<double>(seen.output.size()), unit.text(),
                            shown(raw.rms), shown(whole.rms), shown(split.rms), shown(whole.most), shown(split.most)});
    }
  }
  return table;
}

Table side_by_side(const std::vector<Pair>& pairs, const Estimate& estimate) {
  const Unit one;
  Table table{"terms", "the model (3.4) by the whole unit and by the channels alone", {}, {}};
  table.columns = {{"term", one}, {"unit", one}};
  for (const char* name : {"whole", "whole_sd", "split", "split_sd", "difference", "difference_sd", "ratio"})
    table.columns.push_back({name, one});
  for (std::size_t p = 0; p < pairs.size(); ++p)
    for (std::size_t i = 0; i < terms; ++i) {
      std::vector<Table::Cell> row{estimate.parameters[place(pairs.size(), 0, p, i)].name,
                                   estimate.parameters[place(pairs.size(), 0, p, i)].unit.text()};
      double value = 0.0, sd = 1.0;
      for (std::size_t set = 0; set < 3; ++set) {
        const std::size_t at = place(pairs.size(), set, p, i);
        const Unit& unit = estimate.parameters[at].unit;
        value = unit.difference_from_si(estimate.parameters[at].value);
        sd = unit.difference_from_si(standard_uncertainty(estimate, at));
        row.insert(row.end(), {value, sd});
      }
      row.emplace_back(value / sd);
      table.rows.push_back(std::move(row));
    }
  return table;
}

}  // namespace tumble::imu_channel_calibration
