#pragma once

#include <map>
#include <memory>
#include <string>

#include "tumble/core/plan.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble::virtual_rig {

/// Course of the rig between two standstills at which instruments were switched on: the schedule as carried out so far,
/// the last segment being open, and the motion that the rig makes of it. Times are [s] since its begin.
class Course {
 public:
  /// `run`, `first`: number and first segment of the run. `begin` [s].
  Course(std::shared_ptr<const Plan> plan, const RandomStream& random, int run, double begin, Segment first);

  double begin() const { return begin_; }  ///< [s] of the station
  const Segment& now() const { return segments_.back(); }
  /// In [s].
  double now_since() const { return since_; }
  const Schedule& segments() const { return segments_; }
  /// Counts the changes.
  std::size_t version() const { return version_; }

  /// The axes do this from `time` on; not before the last change. At the time of the last change it is in place of
  /// that, or after it where `anew`. `time` [s].
  void change(double time, std::map<std::string, Motion> axes, bool anew = false);

  /// Valid until `until` at least. `until` [s].
  const Reference& reference(double until);
  /// When all axes do what was commanded last, if nothing else is commanded. [s].
  double settled();

 private:
  std::shared_ptr<const Plan> plan_;
  RandomStream random_;
  int run_;
  double begin_;
  Schedule segments_;
  double since_ = 0.0;    ///< begin of the last segment
  double horizon_ = 0.0;  ///< until where the reference holds
  std::size_t version_ = 0, made_ = 0;
  Reference reference_;
};

}  // namespace tumble::virtual_rig
