#include "tumble/core/marks.hpp"

#include <algorithm>

namespace tumble {

double end_of_mark(const Recording& recording, std::size_t mark) {
  const double planned = recording.marks[mark].end;
  return mark + 1 < recording.marks.size() ? std::min(planned, recording.marks[mark + 1].begin) : planned;
}

}  // namespace tumble
