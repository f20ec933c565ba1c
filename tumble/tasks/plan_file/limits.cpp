#include "tumble/tasks/plan_file/limits.hpp"

#include <cmath>

#include "tumble/core/tables/document.hpp"
#include "tumble/units/error.hpp"

namespace tumble::plan_file {

using tables::FileProblems;
using tables::Section;

namespace {

std::optional<Quantity> read_bound(Section& section, std::string_view key) {
  const auto* node = section.find(key);
  if (!node) return std::nullopt;
  try {
    const auto text = tables::text_of(*node);
    if (!text || node->is_array()) {
      section.problem_at(key, "a quantity is expected, for example \"0.02 deg/h\"");
      return std::nullopt;
    }
    const Quantity bound = parse_quantity(*text);
    if (std::isfinite(bound.unit.to_si(bound.value))) return bound;
    section.problem_at(key, say("'{}' is out of range", *text));
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at(key, problem);
  }
  return std::nullopt;
}

}  // namespace

std::vector<LimitEntry> read_limits(const toml::array& tables, FileProblems& problems) {
  std::vector<LimitEntry> limits;
  for (const auto& node : tables) {
    const auto& table = *node.as_table();
    Section section(table, "[[limit]]", problems);
    LimitEntry limit;
    limit.parameter = section.text("parameter").value_or("");
    if (!table.contains("parameter")) section.missing("parameter", "\"bias\"");
    limit.min = read_bound(section, "min");
    limit.max = read_bound(section, "max");
    limit.where = problems.place(table.source());
    if (!table.contains("min") && !table.contains("max")) section.missing("max", "\"0.02 deg/h\"");
    if (limit.min && limit.max && limit.min->unit.dimension() != limit.max->unit.dimension())
      section.problem("min and max have different dimensions");
    else if (limit.min && limit.max &&
             limit.min->unit.to_si(limit.min->value) > limit.max->unit.to_si(limit.max->value))
      section.problem("min lies above max");
    section.close();
    limits.push_back(std::move(limit));
  }
  return limits;
}

}  // namespace tumble::plan_file
