#include "tumble/tasks/provenance.hpp"

#include <algorithm>
#include <filesystem>

#include "tumble/tasks/sets.hpp"

namespace tumble {
namespace {

void add_file(const Plan& test, const Plan& plan, Provenance& provenance) {
  if (plan.file.empty()) return;
  const auto name = relative_to(test, plan.file);
  if (std::ranges::none_of(provenance.plans, [&](const auto& known) { return known.file == name; }))
    provenance.plans.push_back({name, plan.sha256, plan.text});
}

}  // namespace

std::string relative_to(const Plan& plan, const std::string& file) {
  if (plan.file.empty() || file.empty()) return file;
  const auto folder = std::filesystem::absolute(plan.file).parent_path().lexically_normal();
  const auto relative = std::filesystem::absolute(file).lexically_normal().lexically_relative(folder);
  return relative.empty() ? file : relative.generic_string();
}

Provenance provenance_of(const Plan& plan) {
  Provenance provenance;
  add_file(plan, plan, provenance);
  for (const auto& recording : plan.recordings)
    if (recording.plan) add_file(plan, *recording.plan, provenance);
  for (const auto& [key, text] : plan.settings.texts()) provenance.settings[key] = text;
  for (const auto& [role, choices] : plan.channels) provenance.settings["channels." + role] = listed(choices);
  provenance.command_line = plan.command_line;
  if (plan.calibration.result) {
    const auto calibration = relative_to(plan, plan.calibration.file);
    provenance.settings["calibration"] = calibration;
    provenance.inputs.push_back({calibration, plan.calibration.sha256});
  }
  return provenance;
}

}  // namespace tumble
