#include "tumble/reduce/order_of_marks.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "tumble/sim/power_up.hpp"

namespace tumble {
namespace {

/// [1] of its duration by which the segment before a pause is longer than planned, as the check schedule_mismatch allows.
constexpr double no_pause = 0.005;
constexpr double no_pause_least = 2.0;  ///< [s] a person or a program needs to set the next mark

bool follows_on(const Segment& segment) {
  return segment.approach || std::ranges::any_of(segment.axes, [](const auto& axis) { return axis.second.continued; });
}

/// The marks of one run that are in the plan, in their order.
using Marks = std::vector<const MarkedSegment*>;

/// Whether the next mark is of a later segment that follows without a pause, so that those between were passed over.
bool passes_over(const MarkedSegment& mark, const MarkedSegment& next) {
  if (next.index == mark.index + 1) return false;
  const double planned = mark.planned->duration;
  return next.begin - mark.begin <= planned + std::max(no_pause * planned, no_pause_least);
}

bool in_order(const Marks& marks) {
  for (std::size_t m = 0; m + 1 < marks.size(); ++m)
    if (marks[m + 1]->index < marks[m]->index || passes_over(*marks[m], *marks[m + 1])) return false;
  return true;
}

/// Whether a run goes on after another one, so that its segments are those of several power-ups.
bool runs_interleave(const Schedule& schedule) {
  std::set<int> begun;
  for (std::size_t s = 0; s < schedule.size(); ++s)
    if ((s == 0 || schedule[s].run != schedule[s - 1].run) && !begun.insert(schedule[s].run).second) return true;
  return false;
}

/// What was carried out of a run that these are the marks of: indices in the schedule.
std::vector<std::size_t> order_of(const Schedule& schedule, const Marks& marks) {
  std::size_t least = marks.front()->index;
  for (const auto* mark : marks) least = std::min(least, mark->index);
  std::vector<std::size_t> order;
  if (least == marks.front()->index)
    for (std::size_t s = 0; s < least; ++s)
      if (schedule[s].run == schedule[least].run) order.push_back(s);
  for (std::size_t m = 0; m < marks.size(); ++m) {
    order.push_back(marks[m]->index);
    if (m + 1 == marks.size() || passes_over(*marks[m], *marks[m + 1])) continue;
    for (std::size_t s = marks[m]->index + 1; s < marks[m + 1]->index; ++s) order.push_back(s);
  }
  return order;
}

}  // namespace

std::optional<CarriedOut> in_order_of_marks(const Plan& plan, const std::vector<MarkedSegment>& marks) {
  std::map<int, Marks> runs;
  for (const auto& mark : marks)
    if (mark.planned != nullptr && mark.planned->run == mark.run) runs[mark.run].push_back(&mark);
  if (std::ranges::all_of(runs, [](const auto& run) { return in_order(run.second); })) return {};
  if (std::ranges::any_of(plan.schedule, follows_on) || runs_interleave(plan.schedule)) return {};
  CarriedOut out;
  for (std::size_t first = 0; first < plan.schedule.size();) {
    const int run = plan.schedule[first].run;
    std::vector<std::size_t> order;
    for (; first < plan.schedule.size() && plan.schedule[first].run == run; ++first) order.push_back(first);
    const auto marked = runs.find(run);
    const bool planned = marked == runs.end() || in_order(marked->second);
    if (!planned) order = order_of(plan.schedule, marked->second);
    for (const std::size_t s : order) {
      out.schedule.push_back(planned ? plan.schedule[s] : with_what_stands(plan.schedule, s));
      out.planned.push_back(s);
    }
  }
  return out;
}

std::vector<double> settled_after(const Conducted& test) {
  std::vector<double> after;
  for (const auto& [power_up, segment] : test.places) {
    const bool carried_out = power_up != Conducted::nowhere;
    after.push_back(
        carried_out ? settled_at(test.power_ups[power_up], segment) - test.power_ups[power_up].begins[segment] : 0.0);
  }
  return after;
}

Conducted conducted(const Plan& plan, const std::vector<MarkedSegment>& marks, bool alone, double rate) {
  Conducted out;
  out.places.resize(plan.schedule.size());
  double begin = 0.0;
  for (std::size_t s = 0; alone && s < plan.schedule.size(); ++s) {
    if (s > 0 && plan.schedule[s].run != plan.schedule[s - 1].run) begin = 0.0;
    out.places[s] = {out.power_ups.size(), 0};
    out.power_ups.push_back(power_up_of(plan, {standing_alone(plan.schedule, s)}, rate));
    out.power_ups.back().offset = begin;
    begin += plan.schedule[s].duration;
  }
  if (alone) return out;
  const auto carried = in_order_of_marks(plan, marks);
  std::size_t next = 0;
  for (auto& run : power_ups(carried ? carried->schedule : plan.schedule, rate)) {
    for (std::size_t s = 0; s < run.segments.size(); ++s, ++next)
      out.places[carried ? carried->planned[next] : next] = {out.power_ups.size(), s};
    out.power_ups.push_back(power_up_of(plan, std::move(run.segments), rate));
  }
  return out;
}

const Conducted& ConductedTests::of(const Plan& plan, const std::vector<MarkedSegment>& marks, bool alone) {
  constexpr double rate = 1.0;  // [Hz]
  if (!alone && in_order_of_marks(plan, marks)) return others_.emplace_back(conducted(plan, marks, alone, rate));
  const auto found = as_planned_.find({&plan, alone});
  if (found != as_planned_.end()) return found->second;
  return as_planned_.emplace(std::pair{&plan, alone}, conducted(plan, {}, alone, rate)).first->second;
}

}  // namespace tumble
