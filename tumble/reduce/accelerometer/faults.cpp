#include "tumble/reduce/accelerometer/faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "tumble/earth/earth.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/reduce/accelerometer/hidden.hpp"
#include "tumble/reduce/accelerometer/samples.hpp"
#include "tumble/reduce/linear/boundaries.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer {
namespace {

using linear::SegmentSummary;
using linear::Solution;

/// [sd], and [1] of the output, within which two segments show the same.
constexpr double same_output_sd = 10.0, same_output = 1e-6;

/// [rad] an arcminute: recorded angles of one position differ by seconds of arc.
constexpr double same_angle = 3e-4;
constexpr double rare_fault = 0.5e-4;  ///< p-value on each side, of the best of all attempts
/// [1] by which residuals must shrink at least, where many positions make less significant.
constexpr double least_factor = 5.0;
constexpr double differs_by = 20.0;        ///< [sd] of a segment, far beyond noise
constexpr double significant_term = 10.0;  ///< [sd] of a term that is too large
/// [1] by which a scale factor differs from the given one. Chosen: data sheets are nearer; a wrong unit is farther.
constexpr double far_from_given = 0.02;
constexpr double greatest_misalignment = 2.0;  ///< [deg] no mounting is worse
constexpr double lost_sd = 3.0;  ///< [sd] of the scale factor, that the cosine of a misalignment takes from it

/// Kind, value, end, amplitude and frequency of the motion of every axis in a segment, unchanged axes included.
using Pose = std::map<std::string, std::array<double, 5>>;

constexpr double hold = static_cast<double>(Motion::Kind::hold);
/// [1] of the greatest output, and standard deviations, within which two segments show one value.
constexpr double one_output = 1e-5, one_output_sd = 5.0;
/// [1] of the greatest output, by which their specific forces differ where the output is clipped: 500 times
/// `one_output`, so that the scale factor of an instrument that is not clipped would show it.
constexpr double other_force = 5e-3;
/// [1] of the greatest specific force, from which on a segment is one of the greatest: 11 degrees about it in a tumble.
constexpr double near_the_end = 0.98;
/// Ratio of the rms residuals with and without these segments. Chosen: an error model without a term that matters does
/// not improve so much by leaving out a few segments; doubled, clipping of less than ten times the other residuals is
/// missed.
constexpr double much_better = 5.0;
/// Standard deviations of a segment, and [1] of its output, by which it shows less than the others predict. Chosen: far
/// beyond noise; below 1e-3 of the output terms that the model lacks can do the same.
constexpr double lacking_sd = 20.0, lacking_share = 1e-3;
/// [pulses] a window, which a counter shows, and [rms residuals of the others], of a position that counts nothing.
constexpr double least_pulses = 2.0, lacking_rms = 5.0;

/// The pose of every segment of a plan.
std::vector<Pose> poses_of(const Plan& plan) {
  std::vector<Pose> poses;
  Pose pose;
  int run = 0;
  for (const auto& segment : plan.schedule) {
    if (segment.run != run) pose.clear();
    run = segment.run;
    for (const auto& [axis, motion] : segment.axes)
      pose[axis] = {static_cast<double>(motion.kind), motion.value, motion.to, motion.amplitude, motion.frequency};
    poses.push_back(pose);
    std::erase_if(pose, [](const auto& axis) { return axis.second[0] != hold; });  // it stops where nobody stated
  }
  return poses;
}

bool is_same(const Pose& a, const Pose& b) {
  const auto motion_of = [](const Pose& pose, const std::string& axis) {
    const auto entry = pose.find(axis);
    return entry == pose.end() ? std::array{hold, 0.0, 0.0, 0.0, 0.0} : entry->second;
  };
  std::set<std::string> axes;
  for (const auto* pose : {&a, &b})
    for (const auto& [axis, motion] : *pose) axes.insert(axis);
  return std::ranges::all_of(axes, [&](const std::string& axis) {
    auto first = motion_of(a, axis), second = motion_of(b, axis);
    const double turn = first[1] - second[1];
    const bool angle = first[0] == hold && second[0] == hold;
    first[1] = second[1] = 0.0;
    return first == second && std::abs(angle ? std::remainder(turn, two_pi) : turn) < same_angle;
  });
}

/// A fit of the segments' means without some of them.
struct Fit {
  double rms = 0.0;
  bool determined = false;        ///< it has more segments than parameters, and they show all parameters
  std::vector<double> predicted;  ///< of the segments that it does not use [SI]
};

/// The segments' means over the model's columns, which are scaled to length 1.
class Means {
 public:
  explicit Means(const Solution& solution) : x_(solution.segments.size(), solution.columns.size()) {
    for (std::size_t i = 0; i < x_.rows; ++i) {
      for (std::size_t j = 0; j < x_.columns; ++j) x_(i, j) = solution.columns[j].regressor(solution.segments[i].felt);
      y_.push_back(solution.segments[i].measured);
    }
    x_ = with_unit_columns(std::move(x_)).first;
  }

  Fit without(const std::vector<std::size_t>& unused) const {
    std::vector<std::size_t> rows;
    std::vector<double> y;
    for (std::size_t i = 0; i < x_.rows; ++i)
      if (std::ranges::find(unused, i) == unused.end()) rows.push_back(i), y.push_back(y_[i]);
    const QrFit qr = qr_fit(chosen_rows(x_, rows), y);
    Fit fit;
    if (rows.size() > qr.rank) fit.rms = std::sqrt(qr.residual_square / static_cast<double>(rows.size() - qr.rank));
    fit.determined = rows.size() > qr.rank && qr.rank == x_.columns;
    for (const auto i : unused) fit.predicted.push_back(dot(row(x_, i), qr.x));
    return fit;
  }

  /// The two segments whose outputs, when exchanged, leave the least residuals.
  struct Exchange {
    std::size_t first = 0, second = 0;
    double rms = std::numeric_limits<double>::infinity();
  };
  Exchange best_exchange() const {
    const QrFit qr = qr_fit(x_, y_);
    const Matrix q = x_ * qr.root;
    const Matrix project = identity(x_.rows) - q * transposed(q);
    const auto residual = project * y_;
    Exchange best;
    for (std::size_t i = 0; i < x_.rows; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const auto moved = difference(column(project, i), column(project, j));
        const double rms =
            norm(scaled_sum(residual, y_[j] - y_[i], moved)) / std::sqrt(static_cast<double>(x_.rows - qr.rank));
        if (rms < best.rms) best = {j, i, rms};
      }
    return best;
  }

 private:
  Matrix x_;
  std::vector<double> y_;
};

/// Segments at the greatest (sign 1) or least (-1) output that show equal values at different specific forces.
std::vector<std::string> clipped(const Solution& solution, double sign) {
  double most = -1e300, span = 0.0;
  for (const auto& s : solution.segments) {
    most = std::max(most, sign * s.measured);
    span = std::max(span, std::abs(s.measured));
  }
  std::vector<const SegmentSummary*> extreme;
  double low = 1e300, high = -1e300;
  for (const auto& s : solution.segments) {
    if (most - sign * s.measured > one_output * span + one_output_sd * s.sd) continue;
    extreme.push_back(&s);
    low = std::min(low, sign * s.felt.specific_force.x);
    high = std::max(high, sign * s.felt.specific_force.x);
  }
  if (extreme.size() < 2 || high - low < other_force * span) return {};
  std::vector<std::string> labels;
  for (const auto* s : extreme) labels.push_back(s->label);
  return labels;
}

/// Positions near level that count nothing throughout, where the others predict pulses: a dead band.
Findings about_nothing_near_level(const Normalised& fit) {
  if (!fit.output.pulses || std::isnan(fit.solution.segments.front().measured)) return {};
  const auto& segments = fit.solution.segments;
  std::vector<std::size_t> nothing;
  for (std::size_t i = 0; i < segments.size(); ++i)
    if (segments[i].measured == 0.0) nothing.push_back(i);
  const Fit others = Means(fit.solution).without(nothing);
  if (nothing.empty() || !others.determined) return {};
  double most = 0.0;
  std::vector<std::string> labels;
  for (std::size_t k = 0; k < nothing.size(); ++k) {
    const double predicted = std::abs(others.predicted[k]);
    if (!(predicted > least_pulses * std::abs(fit.problem.scale)) || !(predicted > lacking_rms * others.rms)) continue;
    labels.push_back(segments[nothing[k]].label);
    most = std::max(most, predicted);
  }
  if (labels.empty()) return {};
  return {{Finding::Severity::error,
           "nothing_near_level",
           {{"segments", quoted(labels, labels.size())}, {"output", most, "g"}},
           "",
           {labels.size()}}};
}

/// Segments at the greatest and least specific force that show less than the others predict, which agree much better
/// without them.
std::vector<std::string> short_of_the_others(const Solution& solution) {
  if (std::isnan(solution.segments.front().measured)) return {};
  double low = 0.0, high = 0.0;
  for (const auto& s : solution.segments) {
    low = std::min(low, s.felt.specific_force.x);
    high = std::max(high, s.felt.specific_force.x);
  }
  const Means means(solution);
  const double all = means.without({}).rms;
  std::vector<std::string> labels;
  for (const int which : {1, 2, 3}) {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < solution.segments.size(); ++i) {
      const double a = solution.segments[i].felt.specific_force.x;
      const bool greatest = a > near_the_end * high, least = a < near_the_end * low;
      if (((which & 1) != 0 && greatest) || ((which & 2) != 0 && least)) out.push_back(i);
    }
    const Fit fit = means.without(out);
    if (out.empty() || !fit.determined || !(fit.rms * much_better < all)) continue;
    for (std::size_t k = 0; k < out.size(); ++k) {
      const auto& segment = solution.segments[out[k]];
      const double lacking = (fit.predicted[k] - segment.measured) * (fit.predicted[k] > 0.0 ? 1.0 : -1.0);
      if (lacking > lacking_sd * segment.sd && lacking > lacking_share * std::abs(fit.predicted[k]))
        labels.push_back(segment.label);
    }
    if (labels.size() == out.size()) return labels;
    labels.clear();
  }
  return labels;
}

}  // namespace

std::string quoted(const std::vector<std::string>& labels, std::size_t most) {
  const auto end = labels.begin() + static_cast<std::ptrdiff_t>(std::min(most, labels.size()));
  const std::string more = labels.size() > most ? fmt::format(", ... ({})", labels.size()) : "";
  return labels.empty() ? "" : fmt::format("'{}'{}", fmt::join(labels.begin(), end, "', '"), more);
}

Findings about_labels(const Plan& plan) {
  const auto poses = poses_of(plan);
  const auto& segments = plan.schedule;
  Findings findings;
  std::vector<bool> done(segments.size(), false);
  std::set<std::string> doubtful;
  for (std::size_t a = 0; a < segments.size(); ++a) {
    std::vector<std::string> labels{segments[a].label};
    for (std::size_t b = a + 1; b < segments.size(); ++b) {
      const bool same = is_same(poses[a], poses[b]);
      if (!same && segments[a].label == segments[b].label) doubtful.insert(segments[a].label);
      if (!same || done[b]) continue;
      done[b] = true;
      if (std::ranges::find(labels, segments[b].label) == labels.end()) labels.push_back(segments[b].label);
    }
    if (labels.size() > 1 && !done[a])
      findings.push_back(
          {Finding::Severity::warning, "one_position_of_several_labels", {{"segments", all_quoted(labels)}}});
  }
  for (const auto& label : doubtful)
    findings.push_back({Finding::Severity::warning, "one_label_of_several_positions", {{"label", label}}});
  return findings;
}

std::size_t different_positions(const Plan& plan) {
  const auto poses = poses_of(plan);
  std::size_t count = 0;
  for (auto pose = poses.begin(); pose != poses.end(); ++pose)
    count += std::none_of(poses.begin(), pose, [&](const Pose& other) { return is_same(*pose, other); });
  return count;
}

void refuse_clipped_and_overflown(const Evidence& evidence, const Normalised& fit) {
  if (linear::misplaced(fit.solution.findings)) return;
  Problems problems;
  if (fit.output.pulses) problems = overflows_of(evidence, fit);
  if (problems.empty())
    for (const double sign : {1.0, -1.0})
      if (const auto labels = clipped(fit.solution, sign); !labels.empty())
        problems.push_back(
            say("{} show the same output, the {} of all, although the specific forces differ: the output is "
                "clipped, or the rig was not moved between them; extend its range, or remove the wrong "
                "segments from the recording",
                Name{quoted(labels)}, sign > 0.0 ? "greatest" : "least"));
  if (problems.empty())
    if (const auto labels = short_of_the_others(fit.solution); labels.size() > 1)
      problems.push_back(
          say("{}, where the specific force is greatest, show less than the other positions predict, which "
              "agree without them: the output is clipped; extend its range, or remove these segments from "
              "the recording",
              Name{quoted(labels)}));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

namespace {

/// Factor by which residuals must shrink so that the best of so many attempts does so by chance with a probability of
/// one in ten thousand.
double significant_factor(std::size_t attempts, std::size_t freedom) {
  const double t = student_quantile(1.0 - rare_fault / static_cast<double>(attempts), static_cast<double>(freedom));
  return std::max(least_factor, std::sqrt(1.0 + t * t / static_cast<double>(freedom)));
}

/// The label of another segment that shows the same output; empty: there is none.
std::string repeated_output(const Solution& solution, const SegmentSummary& segment, double rms) {
  const double limit = same_output_sd * (rms + segment.sd) + same_output * std::abs(segment.measured);
  for (const auto& other : solution.segments)
    if (&other != &segment && std::abs(other.measured - segment.measured) < limit) return other.label;
  return "";
}

Findings about_misplaced(const Solution& solution) {
  const std::size_t n = solution.segments.size(), p = solution.columns.size();
  if (n < p + 3 || std::isnan(solution.segments.front().measured)) return {};
  const Means means(solution);
  const double all = means.without({}).rms;
  std::size_t worst = 0;
  Fit best{all, false, {}};
  for (std::size_t i = 0; i < n; ++i)
    if (Fit fit = means.without({i}); fit.determined && fit.rms < best.rms) worst = i, best = std::move(fit);
  const auto exchange = means.best_exchange();
  const auto differs = [&](double by, const SegmentSummary& s) { return std::abs(by) > differs_by * s.sd; };
  const auto &first = solution.segments[exchange.first], &second = solution.segments[exchange.second];
  if (exchange.rms < best.rms && exchange.rms * significant_factor(n * (n - 1) / 2, n - p) < all &&
      differs(first.measured - second.measured, first))
    return {{Finding::Severity::warning,
             "outputs_exchanged",
             {{"segment", first.label}, {"other", second.label}, {"times", all / exchange.rms}}}};
  const auto& segment = solution.segments[worst];
  if (!best.determined || !(best.rms * significant_factor(n, n - p - 1) < all) ||
      !differs(segment.measured - best.predicted[0], segment))
    return {};
  const std::string other = repeated_output(solution, segment, best.rms);
  return {{Finding::Severity::warning,
           other.empty() ? "position_disagrees" : "position_disagrees_and_repeats",
           {{"segment", segment.label},
            {"shown", segment.measured, "g"},
            {"off", segment.measured - best.predicted[0], "g"},
            {"times", all / best.rms},
            {"other", other}}}};
}

/// Coefficients that no accelerometer has, even if they fit: with few positions they absorb the errors of a clipped or
/// overflown output.
Findings about_sizes(const Estimate& estimate) {
  constexpr double most = 0.005;  // of the specific force at 1 g
  Findings findings;
  for (const auto& [name, power] :
       {std::pair{"second_order_coefficient", 1.0}, std::pair{"third_order_coefficient", 2.0},
        std::pair{"cross_coupling_ip", 1.0}, std::pair{"cross_coupling_io", 1.0}}) {
    const Parameter* parameter = find_parameter(estimate, name);
    if (!parameter) continue;
    const double share = parameter->value * std::pow(standard_gravity, power);
    const auto j = static_cast<std::size_t>(parameter - estimate.parameters.data());
    if (std::abs(share) < most || std::abs(parameter->value) < significant_term * standard_uncertainty(estimate, j))
      continue;
    findings.push_back(
        {Finding::Severity::error, "coefficient_too_large", {{"parameter", name}, {"share", share, "%"}}});
  }
  return findings;
}

Findings about_signs(const Estimate& estimate, const Settings& settings, const Output& output) {
  using enum Finding::Severity;
  Findings findings;
  const Parameter* scale = find_parameter(estimate, "scale_factor");
  if (!scale) return findings;
  const auto given = given_scale_factor(settings, output);
  const double ratio = scale->value / given.value_or(1.0);
  if (ratio < 0.0)
    findings.push_back({error, given ? "scale_factor_of_other_sign" : "scale_factor_negative", {}, "scale_factor"});
  else if (given && std::abs(ratio - 1.0) > far_from_given)
    findings.push_back({warning, "scale_factor_far_from_given", {{"difference", ratio - 1.0, "%"}}});
  const auto j = static_cast<std::size_t>(scale - estimate.parameters.data());
  const double relative_sd = standard_uncertainty(estimate, j) / std::abs(scale->value);
  for (const char* name : {"misalignment_o", "misalignment_p"}) {
    const Parameter* angle = find_parameter(estimate, name);
    if (!angle) continue;
    const double lost = 0.5 * angle->value * angle->value;
    if (std::abs(angle->value) > si(greatest_misalignment, "deg"))
      findings.push_back({warning, "misalignment_too_large", {{"parameter", name}, {"angle", angle->value, "deg"}}});
    else if (lost > lost_sd * relative_sd)
      findings.push_back({error,
                          "misalignment_changes_scale_factor",
                          {{"parameter", name}, {"angle", angle->value, "deg"}, {"lost", lost, "ppm"}},
                          "scale_factor"});
  }
  return findings;
}

}  // namespace

void add_faults(const Evidence& evidence, const Normalised& fit, Estimate& estimate) {
  for (const Findings& findings : {about_unsettled(evidence, fit), about_limits(evidence, fit),
                                   about_nothing_near_level(fit), about_misplaced(fit.solution),
                                   about_signs(estimate, evidence.plan.settings, fit.output), about_sizes(estimate)})
    estimate.findings.insert(estimate.findings.end(), findings.begin(), findings.end());
}

}  // namespace tumble::accelerometer
