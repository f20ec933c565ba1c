#include "tumble/rehearsal/virtual_rig/course.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/sim/power_up.hpp"

namespace tumble::virtual_rig {
namespace {

constexpr double foresight = 600.0;  ///< [s] least time that a reference is made for in advance
constexpr double growth = 1.1;       ///< of that time, where a rig with a state of its own must be made anew

/// The duration with which a segment that begins at `begin` ends at `end`, to the last bit of the sum.
double duration_between(double begin, double end) {
  double duration = end - begin;
  for (int k = 0; k < 4 && begin + duration != end; ++k)
    duration = std::nextafter(duration, begin + duration < end ? HUGE_VAL : -HUGE_VAL);
  return duration;
}

}  // namespace

Course::Course(std::shared_ptr<const Plan> plan, const RandomStream& random, int run, double begin, Segment first)
    : plan_(std::move(plan)), random_(random), run_(run), begin_(begin), segments_{std::move(first)} {}

void Course::change(double time, std::map<std::string, Motion> axes, bool anew) {
  if (time > since_ || anew) {
    segments_.back().duration = duration_between(since_, time);
    segments_.push_back({"", 0.0, run_, {}});
    since_ = time;
  }
  segments_.back().axes = std::move(axes);
  ++version_;
  horizon_ = 0.0;
}

const Reference& Course::reference(double until) {
  if (made_ == version_ && horizon_ >= until && horizon_ > 0.0) return reference_;
  horizon_ = std::max(until + foresight, growth * until);
  segments_.back().duration = std::max(foresight, horizon_ - since_);
  PlannedRun run{run_, begin_, 0, segments_};
  reference_ = reference_of(*plan_, run, random_);
  made_ = version_;
  return reference_;
}

double Course::settled() { return reference(since_).settled.back(); }

}  // namespace tumble::virtual_rig
