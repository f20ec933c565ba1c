#include "tumble/tasks/stopping_rule.hpp"

#include <fmt/format.h>

#include "tumble/core/tables/document.hpp"
#include "tumble/core/tables/section.hpp"
#include "tumble/tasks/plan_file/schedule.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

StoppingRule parse_stopping_rule(std::string_view text, double at_least) {
  const auto refuse = [&]() -> StoppingRule {
    throw Error(Error::Kind::bad_input,
                say("'{}' is not a stopping rule: sd(PARAMETER) <= QUANTITY is expected, for example "
                    "sd(bias) <= 0.002 deg/h",
                    text));
  };
  const auto close = text.find(')'), sign = text.find("<=");
  if (!text.starts_with("sd(") || close == std::string_view::npos || close <= 3 || sign == std::string_view::npos)
    return refuse();
  if (sign < close || text.substr(close + 1, sign - close - 1).find_first_not_of(' ') != std::string_view::npos)
    return refuse();
  const Quantity quantity = parse_quantity(text.substr(sign + 2));
  StoppingRule rule{std::string(text), std::string(text.substr(3, close - 3)),
                    quantity.unit.difference_to_si(quantity.value), at_least, quantity.unit};
  return rule.sd > 0.0 ? rule : refuse();
}

std::map<std::string, StoppingRule> stopping_rules(const Plan& plan) {
  std::map<std::string, StoppingRule> rules;
  if (!plan.text) return rules;
  const toml::table document = tables::document_of(*plan.text, plan.file);
  const auto* segments = document.get_as<toml::array>("schedule");
  if (!segments) return rules;
  tables::FileProblems problems{plan.file, {}};
  std::map<std::string, bool> ruled;  // by label: whether its first segment has a rule
  for (const auto& node : *segments) {
    const auto* table = node.as_table();
    if (!table) continue;
    tables::Section section(*table, "[[schedule]]", problems);
    const std::string label = section.text("label").value_or("");
    const auto rule = plan_file::read_stopping_rule(section, section.quantity("duration", Unit::parse("s")));
    const auto [known, is_new] = ruled.emplace(label, rule.has_value());
    if (is_new && rule) rules.emplace(label, *rule);
    if (!is_new && (known->second != rule.has_value() || (rule && !(rules.at(label) == *rule))))
      section.problem(say("the segments '{}' have different stopping rules: give them different labels", label));
  }
  if (!problems.all.empty()) throw Error(Error::Kind::bad_input, problems.sorted());
  return rules;
}

}  // namespace tumble
