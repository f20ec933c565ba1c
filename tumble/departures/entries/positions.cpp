#include <algorithm>
#include <optional>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"
#include "tumble/sim/power_up.hpp"

namespace tumble::entries {
namespace {

/// A segment that can be carried out in another place: it stands by itself and holds a position of the axes.
bool stands_alone(const Segment& segment) {
  return !segment.approach && !segment.axes.empty() && std::ranges::none_of(segment.axes, [](const auto& axis) {
    return axis.second.continued || axis.second.from.has_value() || axis.second.kind == Motion::Kind::slew ||
           axis.second.kind == Motion::Kind::ramp;
  });
}

bool do_the_same(const Segment& first, const Segment& second) {
  return std::ranges::equal(first.axes, second.axes, [](const auto& a, const auto& b) {
    return a.first == b.first && a.second.kind == b.second.kind && a.second.value == b.second.value &&
           a.second.amplitude == b.second.amplitude && a.second.frequency == b.second.frequency;
  });
}

/// From here on each segment says where all axes are: a label means a position, whatever was before it. The fixture stays
/// as it is mounted.
void state_all(Schedule& schedule, std::size_t first) {
  const Schedule before = schedule;
  for (std::size_t s = first; s < std::min(first + 3, schedule.size()); ++s)
    if (stands_alone(before[s])) schedule[s] = with_what_stands(before, s);
}

/// Pairs of neighbours of one power-up that differ in what they do: the index of the first.
std::vector<std::size_t> neighbours(const Schedule& schedule) {
  std::vector<std::size_t> pairs;
  for (std::size_t i = 0; i + 1 < schedule.size(); ++i) {
    const Segment &first = schedule[i], &second = schedule[i + 1];
    if (first.run == second.run && first.label != second.label && stands_alone(first) && stands_alone(second) &&
        !do_the_same(with_what_stands(schedule, i), with_what_stands(schedule, i + 1)))
      pairs.push_back(i);
  }
  return pairs;
}

std::vector<std::string> swappable(const Plan& plan, const Recordings&) {
  return neighbours(plan.schedule).empty() ? std::vector<std::string>{} : std::vector<std::string>{""};
}

std::size_t drawn(const std::vector<std::size_t>& from, const Happening& what) {
  const auto index = static_cast<std::size_t>(what.random.uniform(0) * static_cast<double>(from.size()));
  return from[std::min(index, from.size() - 1)];
}

void swap_order(Plan& plan, const Happening& what) {
  const std::size_t first = drawn(neighbours(plan.schedule), what);
  state_all(plan.schedule, first);
  std::swap(plan.schedule[first], plan.schedule[first + 1]);
}

/// The operator goes to each of two positions when the other one was due, and the labels stay as planned.
void swap_unlabelled(Plan& plan, const Happening& what) {
  const std::size_t first = drawn(neighbours(plan.schedule), what);
  state_all(plan.schedule, first);
  std::swap(plan.schedule[first].axes, plan.schedule[first + 1].axes);
}

void skip_one(Plan& plan, const Happening& what) {
  const std::size_t first = drawn(neighbours(plan.schedule), what);
  state_all(plan.schedule, first);
  plan.schedule.erase(plan.schedule.begin() + static_cast<std::ptrdiff_t>(first) + 1);
}

/// The instrument stays where it was for the time of the next position.
void repeat_one(Plan& plan, const Happening& what) {
  const std::size_t first = drawn(neighbours(plan.schedule), what);
  state_all(plan.schedule, first);
  plan.schedule[first + 1].axes = plan.schedule[first].axes;
}

}  // namespace

std::vector<Departure> of_positions() {
  return {{.name = "order_changed",
           .summary = "two neighbouring segments are carried out in the other order, and their labels say so",
           .targets = swappable,
           .told_by = {},
           .carry_out = swap_order},
          {.name = "labels_exchanged",
           .summary = "two neighbouring segments are carried out in the other order, and their labels do not say so",
           .targets = swappable,
           .told_by = {"positions_exchanged", "positions_look_exchanged", "positions_not_as_planned",
                       "labels_may_be_exchanged", "position_disagrees", "position_disagrees_and_repeats",
                       "segment_reads_as_another", "section_reads_as_another", "angle_off_plan",
                       "another_motion_recorded", "turn_rate_recorded", "positions_off_circle",
                       "accelerometers_do_not_fit_plan", "level_turns_as_another", "tone_of_another_segment"},
           .carry_out = swap_unlabelled},
          {.name = "position_missing",
           .summary = "one segment is not carried out, and there is no mark of it",
           .targets = swappable,
           .told_by = {"segment_not_recorded", "not_recorded", "position_missing", "position_missing_other_twice"},
           .carry_out = skip_one},
          {.name = "position_twice",
           .summary = "the rig stays for the time of the next segment, whose label is recorded",
           .targets = swappable,
           .told_by = {"position_missing_other_twice", "one_position_of_several_labels", "position_disagrees",
                       "position_disagrees_and_repeats", "positions_not_as_planned", "segment_reads_as_another",
                       "section_reads_as_another", "angle_off_plan", "another_motion_recorded", "positions_off_circle",
                       "accelerometers_do_not_fit_plan", "level_turns_as_another", "tone_of_another_segment"},
           .carry_out = repeat_one}};
}

}  // namespace tumble::entries
