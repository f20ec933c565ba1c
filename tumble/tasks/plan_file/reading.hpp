#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/core/tables/section.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/tasks/sets.hpp"
#include "tumble/units/error.hpp"

namespace tumble::plan_file {

/// A plan while it is read: what the sections that come later need of those before them.
struct Reading {
  Plan plan;
  tables::FileProblems problems;
  SortedSets sets;
  const Method* method = nullptr;
  const Model* model = nullptr;
  const Rig* rig = nullptr;
  bool part = false;                                              ///< of another plan, which says the method
  bool clean_schedule = false;                                    ///< and a clean rig: what they ask can be put to it
  std::map<std::string, std::shared_ptr<const Plan>> parts = {};  ///< plans of recordings, by file; null: refused
};

/// Runs `find`, a look-up in a catalogue; what it says when the name is unknown becomes a problem of that key.
template <class Find>
auto look_up(tables::Section& section, std::string_view key, Find find) -> decltype(&find()) {
  try {
    return &find();
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at(key, problem);
    return nullptr;
  }
}

/// The keys of a table, as overridden by the command line, against what `options` accept.
Settings resolve_section(Reading& reading, tables::Section& section, const std::vector<Option>& options,
                         const Sentence& what, const std::vector<Given>& sets);

}  // namespace tumble::plan_file
