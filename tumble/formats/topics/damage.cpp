#include "tumble/formats/topics/damage.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace tumble::topics {

void name_damage(const Damage& damage, const std::vector<std::string>& unreadable, Findings& findings) {
  if (damage.stretches > 0)
    findings.push_back({Finding::Severity::warning,
                        "log_damaged",
                        {{"size", damage.bytes}, {"at", damage.first}},
                        "",
                        {damage.stretches, {}, {}}});
  if (damage.cut_off > 0) findings.push_back({Finding::Severity::warning, "log_cut_off", {{"size", damage.cut_off}}});
  if (damage.undescribed > 0 || !unreadable.empty())
    findings.push_back({Finding::Severity::info,
                        "messages_not_described",
                        {{"what", unreadable.empty() ? "?" : fmt::format("{}", fmt::join(unreadable, ", "))}},
                        "",
                        {damage.undescribed, {}, {}}});
}

}  // namespace tumble::topics
