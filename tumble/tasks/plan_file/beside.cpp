#include "tumble/tasks/plan_file/beside.hpp"

#include <algorithm>

namespace tumble::plan_file {
namespace {

using tables::FileProblems;
using tables::Section;

/// A further instrument. Of the plan's own model it has the plan's truth, but for what it says itself.
Beside read_one_beside(Reading& reading, const std::string& name, const toml::table& table, const toml::table& truth) {
  Section section(table, "[beside." + name + "]", reading.problems);
  Beside beside{name, section.text("model").value_or(reading.plan.instrument_model), {}};
  const Model* model = beside.model.empty()
                           ? nullptr
                           : look_up(
                                 section, "model", [&]() -> auto& { return find_model(beside.model); });
  if (beside.model.empty()) section.missing("model", "\"fiber_optic_gyro\"");
  beside.mount_roll = section.quantity("mount_roll", Unit::parse("deg")).value_or(0.0);
  beside.mount_pitch = section.quantity("mount_pitch", Unit::parse("deg")).value_or(0.0);
  beside.mount_yaw = section.quantity("mount_yaw", Unit::parse("deg")).value_or(0.0);
  const auto* own = section.table("truth");
  std::vector<Given> given;
  if (beside.model == reading.plan.instrument_model) {
    FileProblems heard;  // the truth of the plan has been read and complained about before
    given = overridden(Section(truth, "[truth]", heard).rest(), reading.sets.truth);
  }
  if (own) given = overridden(std::move(given), Section(*own, "[beside." + name + ".truth]", reading.problems).rest());
  std::vector<Given> sets;
  for (const auto& set : reading.sets.beside)
    if (const std::string start = name + ".truth."; set.key.starts_with(start)) {
      sets.push_back(set);
      sets.back().key = set.key.substr(start.size());
    }
  if (model)
    beside.truth = resolve(truth_options(*model), overridden(std::move(given), sets),
                           say("model {}", Name{beside.model}), reading.problems.all);
  section.close();
  return beside;
}

}  // namespace

void read_beside(Reading& reading, const toml::table& tables, const toml::table& truth) {
  Section section(tables, "[beside]", reading.problems);
  auto names = section.unread();  // by the alphabet; the order of the file is that of the channels
  std::ranges::sort(names, {}, [&](const std::string& name) { return tables.get(name)->source().begin.line; });
  for (const auto& name : names)
    if (const auto* table = section.table(name))
      reading.plan.beside.push_back(read_one_beside(reading, name, *table, truth));
  for (const auto& set : reading.sets.beside) {
    const auto known = [&](const Beside& one) { return set.key.starts_with(one.name + ".truth."); };
    if (std::none_of(reading.plan.beside.begin(), reading.plan.beside.end(), known))
      reading.problems.all.push_back(say("--set beside.{}: the plan has no such [beside.NAME.truth]", Name{set.key}));
  }
}

}  // namespace tumble::plan_file
