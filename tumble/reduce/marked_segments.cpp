#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "tumble/core/marks.hpp"
#include "tumble/reduce/stretches.hpp"

namespace tumble {
namespace {

/// How often each segment of a plan has been recorded in a run.
using Uses = std::map<std::tuple<const Plan*, int, std::size_t>, std::size_t>;

/// The segments of a plan that a mark may be of: those of its run, else of any run that states its label.
std::vector<std::size_t> candidates_of(const Plan& plan, const Mark& mark) {
  std::vector<std::size_t> of_run, elsewhere;
  for (std::size_t s = 0; s < plan.schedule.size(); ++s)
    if (plan.schedule[s].label == mark.label) (plan.schedule[s].run == mark.run ? of_run : elsewhere).push_back(s);
  return of_run.empty() ? elsewhere : of_run;
}

/// Places the marks of one recording after the other in the schedules of their plans.
class Placement {
 public:
  /// The marks of the next recording of this plan, in their order.
  std::vector<MarkedSegment> of(const Plan& plan, const Recording& recording, std::size_t number) {
    taken_.clear();
    std::vector<MarkedSegment> marked;
    for (std::size_t m = 0; m < recording.marks.size(); ++m) {
      const Mark& mark = recording.marks[m];
      marked.push_back({number, m, mark.label, mark.run, mark.begin, end_of_mark(recording, m)});
      place(plan, recording, marked.back());
    }
    set_repetitions(plan, marked);
    for (auto& mark : marked)
      mark.start = starts_.try_emplace({&plan, mark.run, mark.repetition}, starts_.size()).first->second;
    return marked;
  }

 private:
  /// Of several segments of one label: a recording that holds them all has them in order. In another recording it is
  /// the one that comes before the next mark and after the last one in the order of the plan, else the one recorded
  /// least often. A recording holds each segment once.
  void place(const Plan& plan, const Recording& recording, MarkedSegment& marked) {
    const Mark& mark = recording.marks[marked.mark];
    const auto candidates = candidates_of(plan, mark);
    const auto of_this_label = [&](const Mark& m) { return m.label == mark.label && m.run == mark.run; };
    const auto held = static_cast<std::size_t>(std::ranges::count_if(recording.marks, of_this_label));
    const bool holds_all = held >= candidates.size();
    const std::size_t bound = bound_by_next(plan, recording, marked.mark);
    const auto last = last_.find({&plan, mark.run});
    std::tuple<bool, bool, std::size_t> least;
    for (const std::size_t s : candidates) {
      if (taken_.contains({mark.run, s})) continue;
      const std::size_t uses = uses_[{&plan, mark.run, s}];
      const std::tuple order{s >= bound, last != last_.end() && s <= last->second, uses};
      if (marked.planned != nullptr && (holds_all || order >= least)) continue;
      least = order;
      marked.planned = &plan.schedule[s];
      marked.index = s;
      marked.repetition = uses;
    }
    if (marked.planned == nullptr) return;
    taken_.insert({mark.run, marked.index});
    last_[{&plan, mark.run}] = marked.index;
  }

  /// The last segment of the plan that the next mark of the run may be of.
  static std::size_t bound_by_next(const Plan& plan, const Recording& recording, std::size_t mark) {
    const auto next = mark + 1;
    if (next == recording.marks.size() || recording.marks[next].run != recording.marks[mark].run) return SIZE_MAX;
    const auto candidates = candidates_of(plan, recording.marks[next]);
    return candidates.empty() ? SIZE_MAX : candidates.back();
  }

  /// One power-up may lie in several files; the same segment in another file is another power-up, and so are the other
  /// segments of that run in that file.
  void set_repetitions(const Plan& plan, std::vector<MarkedSegment>& of_recording) {
    std::map<int, std::size_t> repetitions;
    for (const auto& marked : of_recording)
      repetitions[marked.run] = std::max(repetitions[marked.run], marked.repetition);
    for (auto& marked : of_recording) {
      marked.repetition = repetitions[marked.run];
      if (marked.planned != nullptr) uses_[{&plan, marked.run, marked.index}] = marked.repetition + 1;
    }
  }

  Uses uses_;
  std::set<std::pair<int, std::size_t>> taken_;              ///< run and segment, in the present recording
  std::map<std::pair<const Plan*, int>, std::size_t> last_;  ///< segment of the last mark placed, by plan and run
  std::map<std::tuple<const Plan*, int, std::size_t>, std::size_t> starts_;
};

}  // namespace

std::vector<std::vector<MarkedSegment>> marked_segments(const Evidence& evidence) {
  std::vector<std::vector<MarkedSegment>> all;
  Placement placement;
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r)
    all.push_back(placement.of(plan_of(evidence, r), evidence.recordings[r], r));
  return all;
}

}  // namespace tumble
