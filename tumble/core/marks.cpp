#include "tumble/core/marks.hpp"

#include <limits>

namespace tumble {

double end_of_mark(const Recording& recording, std::size_t mark) {
  return mark + 1 < recording.marks.size() ? recording.marks[mark + 1].begin : std::numeric_limits<double>::infinity();
}

}  // namespace tumble
