#include "tumble/exchange/decision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <charconv>
#include <cmath>

#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

using Kind = DecisionRule::Kind;

/// Probability [1] of more than x standard deviations, of Student's t with so many degrees of freedom.
double tail(double x, double degrees_of_freedom) {
  if (std::isinf(x)) return x > 0.0 ? 0.0 : 1.0;
  if (std::isinf(degrees_of_freedom)) return normal_above(x);
  return cdf(complement(boost::math::students_t_distribution<double>(degrees_of_freedom), x));
}

bool has_own_interval(const Measured& measured) {
  return std::isfinite(measured.lower) && std::isfinite(measured.upper);
}

/// Distribution of the true value about the measured one: its width to each side [u] and its degrees of freedom.
struct Spread {
  double below, above, degrees_of_freedom;
};

Spread spread_of(const Measured& measured) {
  if (!has_own_interval(measured)) return {measured.sd, measured.sd, measured.degrees_of_freedom};
  const double quantile = student_quantile(0.975, INFINITY);
  return {(measured.value - measured.lower) / quantile, (measured.upper - measured.value) / quantile, INFINITY};
}

/// Probability that the true value is above a limit.
double above(const Spread& spread, double value, double limit) {
  const double distance = limit - value;
  const double width = distance < 0.0 ? spread.below : spread.above;
  if (width == 0.0) return distance < 0.0 ? 1.0 : 0.0;  // as close as the interval says
  return tail(distance / width, spread.degrees_of_freedom);
}

double below(const Spread& spread, double value, double limit) {
  return above({spread.above, spread.below, spread.degrees_of_freedom}, -value, -limit);
}

double risk_at(const Spread& spread, double value, const Tolerance& tolerance) {
  return below(spread, value, tolerance.lower) + above(spread, value, tolerance.upper);
}

/// The value of least risk: within the tolerance the risk is convex.
double safest(const Spread& spread, const Tolerance& tolerance) {
  double low = tolerance.lower, high = tolerance.upper;
  for (int step = 0; step < 200 && low < high; ++step) {
    const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
    if (risk_at(spread, a, tolerance) <= risk_at(spread, b, tolerance))
      high = b;
    else
      low = a;
  }
  return low + 0.5 * (high - low);
}

/// Where the risk crosses `most` between a value that is accepted and one that is not.
double crossing(const Spread& spread, const Tolerance& tolerance, double most, double accepted, double refused) {
  for (int step = 0; step < 200; ++step) {
    const double middle = accepted + 0.5 * (refused - accepted);
    if (middle == accepted || middle == refused) break;
    (risk_at(spread, middle, tolerance) <= most ? accepted : refused) = middle;
  }
  return accepted;
}

Tolerance acceptance_by_risk(const Measured& measured, const Tolerance& tolerance, double most) {
  const Spread spread = spread_of(measured);
  const double quantile = -student_quantile(most, spread.degrees_of_freedom);
  if (!tolerance.two_sided())
    return {tolerance.lower + quantile * spread.below, tolerance.upper - quantile * spread.above};
  const double best = safest(spread, tolerance);
  if (risk_at(spread, best, tolerance) > most) return {INFINITY, -INFINITY};
  return {crossing(spread, tolerance, most, best, tolerance.lower),
          crossing(spread, tolerance, most, best, tolerance.upper)};
}

double number_of(std::string_view text, std::string_view rule, double lowest, double highest, const char* what) {
  if (const auto value = as_number<double>(text); value && *value >= lowest && *value <= highest) return *value;
  throw Error(Error::Kind::bad_input, say("rule '{}': {} is expected, from {:g} to {:g}", rule, what, lowest, highest));
}

Decision::Outcome outcome_of(const Measured& measured, const Tolerance& tolerance, const DecisionRule& rule,
                             const Tolerance& acceptance) {
  using enum Decision::Outcome;
  if (rule.kind == Kind::non_binary) {
    const auto [down, up] = expanded_uncertainty(measured);
    if (acceptance.holds(measured.value)) return pass;
    if (tolerance.holds(measured.value)) return conditional_pass;
    return Tolerance{tolerance.lower - up, tolerance.upper + down}.holds(measured.value) ? conditional_fail : fail;
  }
  if (acceptance.empty()) return undecided;
  return acceptance.holds(measured.value) ? pass : fail;
}

}  // namespace

DecisionRule parse_decision_rule(std::string_view text) {
  const auto with_amount = key_and_value(text, ':');
  if (with_amount && with_amount->first == "guarded")
    return {Kind::guarded, number_of(with_amount->second, text, -3.0, 3.0,
                                     "the guard band in expanded uncertainties, such as guarded:0.83")};
  if (with_amount && with_amount->first == "risk")
    return {Kind::risk, number_of(with_amount->second, text, 1e-9, 0.5, "a probability, such as risk:0.025")};
  if (text == "guarded") return {Kind::guarded, 1.0};
  if (text == "simple") return {Kind::simple, 0.0};
  if (text == "method6") return {Kind::method6, 0.0};
  if (text == "non-binary") return {Kind::non_binary, 1.0};
  throw Error(Error::Kind::bad_input,
              say("rule '{}' is not known: simple, guarded:FACTOR, risk:PROBABILITY, method6 or non-binary is "
                  "expected",
                  text));
}

std::string name(const DecisionRule& rule) {
  switch (rule.kind) {
    case Kind::guarded:
      return fmt::format("guarded:{}", rule.amount);
    case Kind::risk:
      return fmt::format("risk:{}", rule.amount);
    case Kind::method6:
      return "method6";
    case Kind::non_binary:
      return "non-binary";
    case Kind::simple:
      break;
  }
  return "simple";
}

ExpandedUncertainty expanded_uncertainty(const Measured& measured) {
  if (has_own_interval(measured)) return {measured.value - measured.lower, measured.upper - measured.value};
  const double half = student_quantile(0.975, measured.degrees_of_freedom) * measured.sd;
  return {half, half};
}

double specific_risk(const Measured& measured, const Tolerance& tolerance) {
  return std::min(1.0, risk_at(spread_of(measured), measured.value, tolerance));
}

Tolerance acceptance_of(const Measured& measured, const Tolerance& tolerance, const DecisionRule& rule) {
  // A value near the upper limit is in danger by what is above it, one near the lower limit by what is below.
  const auto [down, up] = expanded_uncertainty(measured);
  const auto inward = [&](double r) { return Tolerance{tolerance.lower + r * down, tolerance.upper - r * up}; };
  switch (rule.kind) {
    case Kind::guarded:
    case Kind::non_binary:
      return inward(rule.amount);
    case Kind::risk:
      return acceptance_by_risk(measured, tolerance, rule.amount);
    case Kind::method6:
      if (!tolerance.two_sided())
        throw Error(Error::Kind::bad_input, "the rule method6 needs a lower and an upper limit; use risk:0.02");
      return inward(method6_guard_band(test_uncertainty_ratio(measured, tolerance)));
    case Kind::simple:
      break;
  }
  return tolerance;
}

Decision decide(const Measured& measured, const Tolerance& tolerance, const DecisionRule& rule) {
  const Tolerance acceptance = acceptance_of(measured, tolerance, rule);
  const double risk = specific_risk(measured, tolerance);
  const auto outcome = outcome_of(measured, tolerance, rule, acceptance);
  const bool accepted = outcome == Decision::Outcome::pass || outcome == Decision::Outcome::conditional_pass;
  return {outcome, acceptance, 1.0 - risk, accepted ? risk : 1.0 - risk, test_uncertainty_ratio(measured, tolerance)};
}

double test_uncertainty_ratio(const Measured& measured, const Tolerance& tolerance) {
  if (!tolerance.two_sided()) return NAN;
  const auto [down, up] = expanded_uncertainty(measured);
  return (tolerance.upper - tolerance.lower) / (down + up);
}

double method6_guard_band(double test_uncertainty_ratio) {
  return std::max(0.0, 1.04 - std::exp(0.38 * std::log(test_uncertainty_ratio) - 0.54));
}

Measured posterior(const Measured& measured, const Population& population) {
  const double of_population = 1.0 / (population.sd * population.sd), own = 1.0 / (measured.sd * measured.sd);
  const double variance = 1.0 / (of_population + own);
  return {variance * (population.mean * of_population + measured.value * own), std::sqrt(variance)};
}

}  // namespace tumble
