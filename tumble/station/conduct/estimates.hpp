#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/station/carry_out.hpp"

namespace tumble::conduct {

/// Estimates during a run: when the estimate so far is asked for while a segment is recorded, and how the executive and
/// people get it.
class Estimates {
 public:
  /// `live` may be null: nothing is estimated.
  Estimates(LiveEstimates* live, const Course& course) : live_(live), course_(course) {}

  /// A segment is recorded from `time` [s] on.
  void begin(const std::string& label, double time);
  /// The steps of the run, which become marks.
  void journal(const JournalRow& row) const;
  /// Asks where it is time, `now` [s], while something is recorded, and takes what was answered: `tell` the executive,
  /// `note` it.
  void look(double now, bool recording, const std::function<void(EstimateNow)>& tell,
            const std::function<void(const Note&)>& note);
  std::vector<RunView::EstimateView> view() const;

 private:
  void take(const LiveEstimates::Answer& answer, const std::function<void(EstimateNow)>& tell,
            const std::function<void(const Note&)>& note);
  const StoppingRule* rule() const;
  std::string slot_of(const LiveEstimates::Answer& answer) const;

  LiveEstimates* live_;
  const Course& course_;
  std::string label_;
  double began_ = 0.0, next_ = 0.0;                       ///< [s]
  bool noted_ = false;                                    ///< of this segment, why its rule cannot be judged
  std::map<std::string, LiveEstimates::Answer> answers_;  ///< the last of each slot that has an estimate
};

}  // namespace tumble::conduct
