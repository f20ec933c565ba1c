#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/tables/document.hpp"
#include "tumble/core/tables/section.hpp"
#include "tumble/rehearsal/virtual_faults.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {
namespace {

using tables::FileProblems;
using tables::Section;

/// The key that says what a fault is about; a fault of the instrument as a whole has none.
const char* key_of(FaultPlace place) {
  switch (place) {
    case FaultPlace::link:
      return "link";
    case FaultPlace::channel:
      return "channel";
    case FaultPlace::axis:
      return "axis";
    case FaultPlace::unit:
      return nullptr;
  }
  return nullptr;
}

const FaultRule* rule_in(Section& section) {
  const auto text = section.text("kind");
  if (!text) {
    section.missing("kind", "\"drop_link\"");
    return nullptr;
  }
  std::vector<std::string> names;
  for (const auto& rule : fault_rules()) {
    if (*text == rule.name) return &rule;
    names.emplace_back(rule.name);
  }
  section.problem_at(
      "kind", say("there is no fault '{}'{}; there are {}", *text, did_you_mean(*text, names), fmt::join(names, ", ")));
  return nullptr;
}

/// A time that is not negative [s].
std::optional<double> time_in(Section& section, std::string_view key) {
  const auto time = section.quantity(key, Unit::parse("s"));
  if (time && !(*time >= 0.0 && std::isfinite(*time))) section.problem_at(key, "a time of 0 s or more is expected");
  return time;
}

/// The size of the fault, in any of the units that its kind takes.
void read_size(Section& section, const FaultRule& rule, VirtualFault& fault) {
  fault.by = rule.by;
  const auto text = section.text("by");
  if (rule.by_units.empty()) {
    if (text) section.problem_at("by", say("{} has no size", Name{rule.name}));
    return;
  }
  if (!text) {
    if (std::isnan(rule.by)) section.missing("by", fmt::format("\"1 {}\"", rule.by_units.front()));
    return;
  }
  for (const char* unit : rule.by_units) try {
      fault.by = parse_si(*text, Unit::parse(unit));
      const bool share = rule.place == FaultPlace::link && rule.kind != FaultKind::delay;
      if (share && !(fault.by > 0.0 && fault.by <= 1.0))
        section.problem_at("by", "more than 0 and at most 100 % is expected");
      if ((rule.kind == FaultKind::delay || rule.kind == FaultKind::chamber_slow) && !(fault.by > 0.0))
        section.problem_at("by", "more than 0 is expected");
      return;
    } catch (const Error&) {  // the next unit
    }
  section.problem_at(
      "by", say("'{}' is not understood: a quantity in {} is expected", *text, fmt::join(rule.by_units, " or ")));
}

void read_when(Section& section, const FaultRule& rule, VirtualFault& fault) {
  const auto at = time_in(section, "at");
  fault.random = section.quantity("random", Unit::parse("1/s"));
  if (at.has_value() == fault.random.has_value())
    section.problem(at ? "has 'at' and 'random': one of them is expected"
                       : "needs at = \"10 min\" or random = \"2 1/h\"");
  if (fault.random && !(*fault.random > 0.0)) section.problem_at("random", "more than 0 is expected");
  fault.at = at.value_or(0.0);
  fault.lasts = time_in(section, "for");
  if (fault.lasts && !rule.lasts) section.problem_at("for", say("{} has no duration", Name{rule.name}));
}

void read_outcome(Section& section, VirtualFault& fault) {
  static const std::vector<std::string> endings{"complete", "aborted", "stopped", "failed", "error", "faulted"};
  if (const auto ends = section.text("ends")) {
    fault.ends = *ends;
    if (std::ranges::find(endings, *ends) == endings.end())
      section.problem_at("ends", say("one of {} is expected", fmt::join(endings, ", ")));
  } else {
    section.missing("ends", "\"stopped\"");
  }
  fault.finding = section.text("finding").value_or("");
  fault.within = time_in(section, "within");
}

VirtualFault read_fault(const toml::table& table, std::size_t number, FileProblems& problems) {
  Section section(table, "[[fault]]", problems);
  VirtualFault fault;
  fault.name = section.text("name").value_or(fmt::format("fault {}", number));
  const FaultRule* rule = rule_in(section);
  if (!rule) {  // what else it says cannot be judged
    for (const char* key : {"link", "channel", "axis", "at", "random", "for", "by", "ends", "finding", "within"})
      section.find(key);
    section.close();
    return fault;
  }
  fault.kind = rule->kind;
  const char* about = key_of(rule->place);
  for (const char* key : {"link", "channel", "axis"}) {
    const auto text = section.text(key);
    if (about && std::string_view(about) == key) {
      fault.about = text.value_or("");
      if (!text && rule->place != FaultPlace::link) section.missing(key, "\"...\"");
    } else if (text) {
      section.problem_at(key, about ? say("{} is about '{}'", Name{rule->name}, Name{about})
                                    : say("{} is about the instrument as a whole", Name{rule->name}));
    }
  }
  read_when(section, *rule, fault);
  read_size(section, *rule, fault);
  read_outcome(section, fault);
  section.close();
  return fault;
}

}  // namespace

std::vector<VirtualFault> read_faults(std::string_view text, const std::string& file) {
  const auto document = tables::document_of(std::string(text), file);
  FileProblems problems{file, {}};
  Section root(document, "", problems);
  std::vector<VirtualFault> faults;
  const auto* node = root.find("fault");
  const auto* list = node ? node->as_array() : nullptr;
  if (!list)
    root.problem("at least one [[fault]] is expected");
  else
    for (const auto& element : *list)
      if (const auto* table = element.as_table())
        faults.push_back(read_fault(*table, faults.size() + 1, problems));
      else
        root.problem_at("fault", "[[fault]] is expected");
  root.close();
  if (!problems.all.empty()) throw Error(Error::Kind::bad_input, problems.sorted());
  return faults;
}

std::vector<VirtualFault> timed_faults(const std::vector<VirtualFault>& faults, std::uint64_t seed, double until) {
  std::vector<VirtualFault> timed;
  const RandomStream random = RandomStream(seed).split("faults");
  for (std::size_t f = 0; f < faults.size(); ++f) {
    if (!faults[f].random) {
      timed.push_back(faults[f]);
      continue;
    }
    const RandomStream own = random.split(f);
    double time = 0.0;
    for (std::uint64_t n = 0;; ++n) {
      time -= std::log(own.uniform(n)) / *faults[f].random;
      if (!(time < until)) break;
      timed.push_back(faults[f]);
      timed.back().at = time;
      timed.back().random.reset();
    }
  }
  std::ranges::stable_sort(timed, {}, &VirtualFault::at);
  return timed;
}

}  // namespace tumble
