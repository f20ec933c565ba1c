#include "tumble/reduce/accelerometer/faults.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "tumble/core/say.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/reduce/accelerometer/samples.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer {
namespace {

using linear::SegmentSummary;
using linear::Solution;

/// What all axes of the rig do in a segment, those that it leaves as they are included.
using Place = std::map<std::string, std::vector<double>>;

/// Of every segment of a plan.
std::vector<Place> places_of(const Plan& plan) {
  std::vector<Place> places;
  Place now;
  int run = 0;
  for (const auto& segment : plan.schedule) {
    if (segment.run != run) now.clear();
    run = segment.run;
    for (const auto& [axis, motion] : segment.axes)
      now[axis] = {static_cast<double>(motion.kind), motion.value, motion.to, motion.amplitude, motion.frequency};
    places.push_back(now);
    for (auto it = now.begin(); it != now.end();)  // an axis that has stopped where nobody said
      it = it->second[0] == static_cast<double>(Motion::Kind::hold) ? std::next(it) : now.erase(it);
  }
  return places;
}

bool same_place(const Place& a, const Place& b) {
  const auto at_zero = [](const Place& one, const std::string& axis) {
    const auto found = one.find(axis);
    return found == one.end() ? std::vector{static_cast<double>(Motion::Kind::hold), 0.0, 0.0, 0.0, 0.0}
                              : found->second;
  };
  std::set<std::string> axes;
  for (const auto* place : {&a, &b})
    for (const auto& [axis, motion] : *place) axes.insert(axis);
  return std::ranges::all_of(axes, [&](const std::string& axis) {
    auto one = at_zero(a, axis), other = at_zero(b, axis);
    const bool angle = one[0] == static_cast<double>(Motion::Kind::hold) && one[0] == other[0];
    const double off = angle ? std::remainder(one[1] - other[1], two_pi) : one[1] - other[1];
    one[1] = other[1] = 0.0;
    return one == other && std::abs(off) < 1e-6;
  });
}

Finding warning(std::string text) { return {Finding::Severity::warning, std::move(text), ""}; }

/// Residuals of the segments' means after least squares without some segments, and what the fit says there.
struct Look {
  double rms = 0.0;
  bool enough = false;            ///< more segments than parameters, and all of these seen
  std::vector<double> predicted;  ///< of those left out [SI]
};

class Means {
 public:
  explicit Means(const Solution& solution) : x_(at(solution.segments.size()), at(solution.columns.size())) {
    y_.resize(x_.rows());
    for (Eigen::Index i = 0; i < x_.rows(); ++i) {
      const auto& segment = solution.segments[static_cast<std::size_t>(i)];
      for (Eigen::Index j = 0; j < x_.cols(); ++j)
        x_(i, j) = solution.columns[static_cast<std::size_t>(j)].regressor(segment.felt);
      y_[i] = segment.measured;
    }
    size_ = x_.colwise().norm();
    for (auto& one : size_)
      if (!(one > 0.0)) one = 1.0;
    x_ = x_ * size_.cwiseInverse().asDiagonal();
  }

  Look without(const std::vector<std::size_t>& left_out) const {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < x_.rows(); ++i)
      if (std::ranges::find(left_out, static_cast<std::size_t>(i)) == left_out.end()) kept.push_back(i);
    const Eigen::MatrixXd x = x_(kept, Eigen::all);
    const Eigen::VectorXd y = y_(kept);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(x);
    const Eigen::VectorXd b = qr.solve(y);
    Look look;
    if (x.rows() > qr.rank()) look.rms = (y - x * b).norm() / std::sqrt(static_cast<double>(x.rows() - qr.rank()));
    look.enough = x.rows() > qr.rank() && qr.rank() == x_.cols();
    for (const auto i : left_out) look.predicted.push_back(x_.row(at(i)).dot(b));
    return look;
  }

  /// Residuals where the outputs of two segments are exchanged: the two for which they are least.
  struct Exchange {
    std::size_t first = 0, second = 0;
    double rms = std::numeric_limits<double>::infinity();
  };
  Exchange best_exchange() const {
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(x_);
    const Eigen::Index n = x_.rows();
    const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(n, qr.rank());
    const Eigen::MatrixXd project = Eigen::MatrixXd::Identity(n, n) - q * q.transpose();
    const Eigen::VectorXd residual = project * y_;
    Exchange best;
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < i; ++j) {
        const double rms = (residual + (y_[j] - y_[i]) * (project.col(i) - project.col(j))).norm() /
                           std::sqrt(static_cast<double>(n - qr.rank()));
        if (rms < best.rms) best = {static_cast<std::size_t>(j), static_cast<std::size_t>(i), rms};
      }
    return best;
  }

 private:
  Eigen::MatrixXd x_;
  Eigen::VectorXd y_, size_;
};

/// Segments at the greatest (sign 1) or least (-1) output that show the same although they should not.
std::vector<std::string> clipped(const Solution& solution, double sign) {
  double most = -1e300, span = 0.0;
  for (const auto& s : solution.segments) {
    most = std::max(most, sign * s.measured);
    span = std::max(span, std::abs(s.measured));
  }
  std::vector<const SegmentSummary*> there;
  double low = 1e300, high = -1e300;
  for (const auto& s : solution.segments) {
    if (most - sign * s.measured > 1e-5 * span + 5.0 * s.sd) continue;
    there.push_back(&s);
    low = std::min(low, sign * s.felt.specific_force.x);
    high = std::max(high, sign * s.felt.specific_force.x);
  }
  if (there.size() < 2 || high - low < 5e-3 * span) return {};
  std::vector<std::string> labels;
  for (const auto* s : there) labels.push_back(s->label);
  return labels;
}

/// Segments at the greatest and least specific force that show less than the others say, which without them agree much
/// better.
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
      if (((which & 1) != 0 && a > 0.98 * high) || ((which & 2) != 0 && a < 0.98 * low)) out.push_back(i);
    }
    const Look look = means.without(out);
    if (out.empty() || !look.enough || !(look.rms * 5.0 < all)) continue;
    for (std::size_t k = 0; k < out.size(); ++k) {
      const auto& segment = solution.segments[out[k]];
      const double lacking = (look.predicted[k] - segment.measured) * (look.predicted[k] > 0.0 ? 1.0 : -1.0);
      if (lacking > 20.0 * segment.sd && lacking > 1e-3 * std::abs(look.predicted[k])) labels.push_back(segment.label);
    }
    if (labels.size() == out.size()) return labels;
    labels.clear();
  }
  return labels;
}

}  // namespace

std::string quoted(const std::vector<std::string>& labels) {
  constexpr std::size_t most = 6;
  std::vector<std::string> out;
  for (std::size_t i = 0; i < std::min(labels.size(), most); ++i) out.push_back("'" + labels[i] + "'");
  if (labels.size() > most) out.push_back(fmt::format("{} more", labels.size() - most));
  if (out.size() < 2) return out.empty() ? "" : out.front();
  return fmt::format("{} and {}", fmt::join(out.begin(), out.end() - 1, ", "), out.back());
}

Findings about_labels(const Plan& plan) {
  const auto places = places_of(plan);
  const auto& segments = plan.schedule;
  Findings findings;
  std::vector<bool> done(segments.size(), false);
  std::set<std::string> doubtful;
  for (std::size_t a = 0; a < segments.size(); ++a) {
    std::vector<std::string> labels{segments[a].label};
    for (std::size_t b = a + 1; b < segments.size(); ++b) {
      const bool same = same_place(places[a], places[b]);
      if (!same && segments[a].label == segments[b].label) doubtful.insert(segments[a].label);
      if (!same || done[b]) continue;
      done[b] = true;
      if (std::ranges::find(labels, segments[b].label) == labels.end()) labels.push_back(segments[b].label);
    }
    if (labels.size() > 1 && !done[a])
      findings.push_back(warning(fmt::format(
          "{} are one position by the plan: they count as repeats of it, not as positions of their own. If that is "
          "meant, give them one label; if not, correct the angles of the plan",
          quoted(labels))));
  }
  for (const auto& label : doubtful)
    findings.push_back(warning(fmt::format(
        "'{}' is the label of different positions: which is which follows from their order alone; give each its own",
        label)));
  return findings;
}

std::size_t different_positions(const Plan& plan) {
  const auto places = places_of(plan);
  std::size_t count = 0;
  for (std::size_t a = 0; a < places.size(); ++a)
    count += std::none_of(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(a),
                          [&](const Place& other) { return same_place(places[a], other); });
  return count;
}

void refuse_clipped_and_overflown(const Evidence& evidence, const Normalised& found) {
  std::vector<std::string> problems;
  if (found.output.pulses) problems = overflows_of(evidence, found);
  if (problems.empty())
    for (const double sign : {1.0, -1.0})
      if (const auto labels = clipped(found.solution, sign); !labels.empty())
        problems.push_back(
            fmt::format("{} show the same output, the {} of all, but should feel different specific forces: the output "
                        "is clipped, or the rig was not moved between them; extend its range, or take the wrong ones "
                        "out of the recording",
                        quoted(labels), sign > 0.0 ? "greatest" : "least"));
  if (problems.empty())
    if (const auto labels = short_of_the_others(found.solution); labels.size() > 1)
      problems.push_back(
          fmt::format("{}, where the specific force is greatest, show less than the other positions say, "
                      "which without them agree: the output is clipped; extend its range, or take these "
                      "segments out of the recording",
                      quoted(labels)));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

namespace {

/// By how much residuals must shrink to be more than the luck of the best of so many attempts, one time in ten
/// thousand.
double beyond_luck(std::size_t attempts, std::size_t freedom) {
  const double t = student_quantile(1.0 - 0.5e-4 / static_cast<double>(attempts), static_cast<double>(freedom));
  return std::max(5.0, std::sqrt(1.0 + t * t / static_cast<double>(freedom)));
}

Finding exchanged(const SegmentSummary& one, const SegmentSummary& other, double times) {
  return warning(
      fmt::format("the outputs of '{}' and '{}' are exchanged, it seems: the other way round all agree {:.0f} "
                  "times better. Are files or labels mixed up?",
                  one.label, other.label, times));
}

}  // namespace

Findings about_misplaced(const Solution& solution) {
  const std::size_t n = solution.segments.size(), p = solution.columns.size();
  if (n < p + 3 || std::isnan(solution.segments.front().measured)) return {};
  const Means means(solution);
  const double all = means.without({}).rms;
  std::size_t odd = 0;
  Look best{all, false, {}};
  for (std::size_t i = 0; i < n; ++i)
    if (const Look look = means.without({i}); look.enough && look.rms < best.rms) odd = i, best = look;
  const auto exchange = means.best_exchange();
  const auto apart = [&](double difference, const SegmentSummary& s) { return std::abs(difference) > 20.0 * s.sd; };
  const auto &one = solution.segments[exchange.first], &other = solution.segments[exchange.second];
  if (exchange.rms < best.rms && exchange.rms * beyond_luck(n * (n - 1) / 2, n - p) < all &&
      apart(one.measured - other.measured, one))
    return {exchanged(one, other, all / exchange.rms)};
  if (!best.enough) return {};
  const auto& segment = solution.segments[odd];
  const double expected = best.predicted[0];
  if (!(best.rms * beyond_luck(n, n - p - 1) < all) || !apart(segment.measured - expected, segment)) return {};
  std::string where;
  for (const auto& next : solution.segments)
    if (&next != &segment && where.empty() &&
        std::abs(next.measured - segment.measured) < 10.0 * (best.rms + segment.sd) + 1e-6 * std::abs(segment.measured))
      where = fmt::format(" It reads as '{}' does: was the rig moved between them?", next.label);
  const Unit g = Unit::parse("g");
  return {warning(
      fmt::format("'{}' does not agree with the others: it shows {}, {} off what they say, and without it they agree "
                  "{:.0f} times better. Take it again, or out of the recording.{}",
                  segment.label, say_difference(segment.measured, g), say_difference(segment.measured - expected, g),
                  all / best.rms, where))};
}

namespace {

/// Coefficients that no accelerometer has, however well they fit: with few positions they take up what a clipped or
/// overflown output leaves.
Findings about_sizes(const Estimate& estimate) {
  constexpr double most = 0.01;  // of the specific force at 1 g
  Findings findings;
  for (const auto& [name, power] :
       {std::pair{"second_order_coefficient", 1.0}, std::pair{"third_order_coefficient", 2.0},
        std::pair{"cross_coupling_ip", 1.0}, std::pair{"cross_coupling_io", 1.0}}) {
    const Parameter* found = find_parameter(estimate, name);
    if (!found) continue;
    const double share = found->value * std::pow(standard_gravity, power);
    const auto j = static_cast<std::size_t>(found - estimate.parameters.data());
    if (std::abs(share) < most || std::abs(found->value) < 10.0 * standard_uncertainty(estimate, j)) continue;
    findings.push_back(
        {Finding::Severity::error,
         fmt::format(
             "{} comes to {:.2g} % of the output at 1 g, which no sound accelerometer has: is the output "
             "clipped, did the counter overflow, are the positions those of the plan? More positions would tell",
             name, 100.0 * share),
         ""});
  }
  return findings;
}

}  // namespace

Findings about_signs(const Estimate& estimate, const Settings& settings, const Output& output) {
  Findings findings;
  const Parameter* scale = find_parameter(estimate, "scale_factor");
  if (!scale) return findings;
  const auto given = given_scale_factor(settings, output);
  if (scale->value * given.value_or(1.0) < 0.0)
    findings.push_back(warning(
        fmt::format("the scale factor is {}: the output falls where the specific force grows. Either the output's "
                    "polarity is reversed, or the axis counts its angle the other way (enter -th for th), or the input "
                    "axis points the other way on the fixture, or gravity was taken as -1 g upwards (Tumble: +1 g)",
                    given ? "of the other sign than the one given" : "negative")));
  else if (given && std::abs(scale->value / *given - 1.0) > 0.02)
    findings.push_back(
        warning(fmt::format("the scale factor differs from the one given by {:.2g} %: is the unit of "
                            "either right, and the length of the windows?",
                            100.0 * (scale->value / *given - 1.0))));
  const auto relative = [&](const Parameter& parameter) {
    return standard_uncertainty(estimate, static_cast<std::size_t>(&parameter - estimate.parameters.data())) /
           std::abs(parameter.value);
  };
  for (const char* name : {"misalignment_o", "misalignment_p"}) {
    const Parameter* angle = find_parameter(estimate, name);
    if (!angle) continue;
    const double size = std::abs(angle->value), lost = 0.5 * size * size;
    const double degrees = Unit::parse("deg").from_si(angle->value);
    if (size > si(2.0, "deg"))
      findings.push_back(warning(fmt::format(
          "{} is {:.3g} deg, too much for a small angle: is the zero of the rig's angle where the input axis is level, "
          "and the accelerometer mounted as the plan says?",
          name, degrees)));
    else if (lost > 3.0 * relative(*scale))
      findings.push_back(warning(fmt::format(
          "{} is {:.3g} deg: if it is the zero of the rig's angle or the mounting, and not of the unit, scale_factor "
          "is {:.0f} ppm too small for it, more than its uncertainty; correct the angles of the plan",
          name, degrees, 1e6 * lost)));
  }
  for (auto& finding : about_sizes(estimate)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace tumble::accelerometer
