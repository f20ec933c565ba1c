#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "tumble/reduce/stretches.hpp"

/// The order in which the segments of a plan were carried out.
namespace tumble {

/// Segments as a recording has them, in place of the schedule of its plan.
struct CarriedOut {
  Schedule schedule;
  std::vector<std::size_t> planned;  ///< a segment each: its index in the schedule of the plan
};

/// The schedule in the order of the marks of one recording: how long a move lasts follows from where the axes stood
/// before. A label says where the axes stand: what a segment does not mention is where the plan's segments before it
/// left it. A segment that the marks pass over without a pause was not carried out. Segments of a run before its first
/// mark were, as planned, if none of them comes later.
///
/// Returned  nothing where the marks are in the order of the plan and pass over no segment, and where the plan does not say
///           what its segments do apart: a motion that goes on from the segment before, a segment that is only an approach
std::optional<CarriedOut> in_order_of_marks(const Plan& plan, const std::vector<MarkedSegment>& marks);

/// The power-ups of a recording, and where the segments of the plan's schedule are in them.
struct Conducted {
  static constexpr std::size_t nowhere = static_cast<std::size_t>(-1);
  struct Place {
    std::size_t power_up = nowhere;  ///< nowhere: it was not carried out
    std::size_t segment = 0;
  };
  std::vector<PowerUp> power_ups;
  std::vector<Place> places;  ///< a segment of the plan's schedule each
};

/// Given     marks  of the recording; none: as planned
///           alone  whether the recording is the file of one segment: each segment is a power-up then, at its own place
///           rate   [Hz] at which the rig is asked
Conducted conducted(const Plan& plan, const std::vector<MarkedSegment>& marks, bool alone, double rate);

/// The power-ups of several recordings at 1 Hz: those in the order of their plan share them.
class ConductedTests {
 public:
  const Conducted& of(const Plan& plan, const std::vector<MarkedSegment>& marks, bool alone);

 private:
  std::map<std::pair<const Plan*, bool>, Conducted> as_planned_;
  std::list<Conducted> others_;
};

/// When every segment of the schedule has settled, after its own beginning [s]; 0 of one that was not carried out.
std::vector<double> settled_after(const Conducted& test);

}  // namespace tumble
