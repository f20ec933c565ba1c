#include "tumble/checks/support/segments.hpp"

#include <cmath>

#include "tumble/core/marks.hpp"

namespace tumble::support {

bool is_between_segments(const Recording& recording, double begin, double end) {
  const auto& marks = recording.marks;
  if (marks.empty()) return false;
  for (std::size_t m = 0; m < marks.size(); ++m) {
    if (!std::isfinite(marks[m].end)) return false;
    if (marks[m].begin < end && end_of_mark(recording, m) > begin) return false;
  }
  return true;
}

}  // namespace tumble::support
