#include "tumble/core/unit_facts.hpp"

#include <optional>

#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

std::string fact_of(const Recording& recording, std::string_view fact) {
  const auto found = recording.meta.find(std::string(fact));
  return found == recording.meta.end() ? "" : found->second;
}

}  // namespace

std::vector<std::string> recorded_slots(const Recording& recording) {
  if (const std::string own = fact_of(recording, "slot"); !own.empty()) return {own};
  std::vector<std::string> slots;
  for (const auto& [fact, value] : recording.meta)
    if (const auto unit = key_and_value(fact, ' '); unit && unit->first == unit_fact) slots.push_back(unit->second);
  return slots;
}

std::string recorded_serial(const Recording& recording, const std::string& slot) {
  const auto slots = recorded_slots(recording);
  if (slots.empty()) return fact_of(recording, unit_fact);
  if (slot.empty() && slots.size() > 1) return "";
  return fact_of(recording, std::string(unit_fact) + " " + (slot.empty() ? slots.front() : slot));
}

bool was_run_by(const Recording& recording, const std::string& sha256) {
  return !sha256.empty() && fact_of(recording, plan_fact) == sha256;
}

}  // namespace tumble
