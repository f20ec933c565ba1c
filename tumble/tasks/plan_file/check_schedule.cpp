#include "tumble/tasks/plan_file/check_schedule.hpp"

#include <algorithm>
#include <map>

#include "tumble/rigs/rig.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::plan_file {
namespace {

/// Where the refusals of a rig point: "[rig] option ..." and "segment 'label' ..." to their lines, others to the file.
class Places {
 public:
  Places(Section& root, const FileProblems& problems) : problems_(problems), rig_(root.table("rig")) {
    const auto* segments = root.find("schedule");
    for (const auto& node : *segments->as_array())
      if (const auto* label = node.as_table()->get_as<std::string>("label"))
        segments_.emplace(label->get(), &node);  // the first of those that share it
  }

  Where of(const std::string& refusal) const {
    const auto quoted = [&](std::size_t from, char end) {
      return refusal.substr(from, refusal.find(end, from) - from);
    };
    const toml::node* node = nullptr;
    if (refusal.starts_with("[rig] ") && rig_) node = rig_->get(quoted(6, ' '));
    if (refusal.starts_with("segment '"))
      if (const auto found = segments_.find(quoted(9, '\'')); found != segments_.end()) node = found->second;
    return node ? problems_.where(node->source())
                : Where{.file = problems_.file, .place = say("{}", Name{problems_.file})};
  }

 private:
  const FileProblems& problems_;
  const toml::table* rig_;
  std::map<std::string, const toml::node*> segments_;
};

Problems refusals_of(const Plan& plan, const Rig& rig) {
  if (!recorded_one_by_one(plan)) return rig.refusals(plan.schedule, plan.rig);
  Problems refusals;
  for (std::size_t s = 0; s < plan.schedule.size(); ++s)
    for (auto& refusal : rig.refusals({standing_alone(plan.schedule, s)}, plan.rig))
      if (std::ranges::find(refusals, refusal) == refusals.end()) refusals.push_back(std::move(refusal));
  return refusals;
}

}  // namespace

void check_schedule(const Plan& plan, const Rig& rig, Section& root, FileProblems& problems) {
  if (!rig.refusals || plan.schedule.empty()) return;
  const auto refusals = refusals_of(plan, rig);
  if (refusals.empty()) return;
  const Places places(root, problems);
  for (const auto& refusal : refusals) problems.all.push_back(within(places.of(refusal.text()), refusal));
}

}  // namespace tumble::plan_file
