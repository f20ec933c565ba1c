#include <fmt/format.h>

#include <cmath>

#include "tumble/exchange/certificate/work.hpp"
#include "tumble/math/normal.hpp"

namespace tumble::certificate {

std::string percent(double probability) {
  const double in_percent = 100.0 * probability;
  if (in_percent > 0.0 && in_percent < 0.01) return "<0.01";
  if (in_percent > 99.99) return ">99.99";
  if (in_percent < 1.0) return fmt::format("{:.2g}", in_percent);
  return in_percent > 99.0 ? fmt::format("{:.2f}", in_percent) : fmt::format("{:.1f}", in_percent);
}

std::string rule_in_words(const DecisionRule& rule, Language language) {
  const auto text = [&](const char* key) { return text_of(language, "certificate", key); };
  const auto with = [&](const char* key, const std::string& first, const std::string& second = "") {
    return fmt::format(fmt::runtime(text(key)), first, second);
  };
  switch (rule.kind) {
    case DecisionRule::Kind::guarded:
      // At the limit, of a normal distribution with U = 1.96 u.
      return with("rule_guarded", fmt::format("{}", rule.amount),
                  percent(normal_above(rule.amount * 1.959963984540054)));
    case DecisionRule::Kind::risk:
      return with("rule_risk", fmt::format("{:g}", 100.0 * rule.amount));
    case DecisionRule::Kind::method6:
      return text("rule_method6");
    case DecisionRule::Kind::non_binary:
      return text("rule_non_binary");
    case DecisionRule::Kind::simple:
      break;
  }
  return text("rule_simple");
}

std::string outcome_in_words(Decision::Outcome outcome, Language language) {
  constexpr const char* keys[] = {"pass", "conditional_pass", "conditional_fail", "fail", "undecided"};
  return text_of(language, "certificate", keys[static_cast<std::size_t>(outcome)]);
}

}  // namespace tumble::certificate
