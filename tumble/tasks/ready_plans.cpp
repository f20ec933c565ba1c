#include "tumble/tasks/ready_plans.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <utility>

#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {

namespace assets {
extern const std::vector<std::pair<std::string_view, std::string_view>> plans;
}

namespace {

ReadyPlan ready_plan(std::string_view name, std::string_view text) {
  const auto table = toml::parse(text, name);
  ReadyPlan plan{name, table["method"].value_or(std::string()), table["title"].value_or(std::string()), text, {}};
  if (const auto* recordings = table["recording"].as_array())
    for (const auto& recording : *recordings)
      if (const auto* one = recording.as_table(); one && one->contains("plan"))
        plan.beside.push_back((*one)["plan"].value_or(std::string()));
  return plan;
}

std::vector<ReadyPlan> all_plans() {
  std::vector<ReadyPlan> plans;
  for (const auto& [name, text] : assets::plans) plans.push_back(ready_plan(name, text));
  std::ranges::sort(plans, {}, &ReadyPlan::name);
  return plans;
}

}  // namespace

const std::vector<ReadyPlan>& ready_plans() {
  static const std::vector<ReadyPlan> plans = all_plans();
  return plans;
}

const ReadyPlan& find_ready_plan(const std::string& name_or_method) {
  const auto& plans = ready_plans();
  if (const auto named = std::ranges::find(plans, name_or_method, &ReadyPlan::name); named != plans.end())
    return *named;
  if (const auto one = std::ranges::find(plans, name_or_method, &ReadyPlan::method); one != plans.end()) return *one;
  std::vector<std::string> known;
  for (const auto& plan : plans) known.emplace_back(plan.name);
  auto meant = known;  // a method is accepted too
  for (const auto& plan : plans)
    if (std::ranges::find(meant, plan.method) == meant.end()) meant.push_back(plan.method);
  throw Error(Error::Kind::unsupported, say("there is no plan '{}'{} (plans: {})", name_or_method,
                                            did_you_mean(name_or_method, meant), fmt::join(known, ", ")));
}

}  // namespace tumble
