#include "tumble/station/conduct/row_wait.hpp"

#include <algorithm>
#include <limits>

namespace tumble::conduct {
namespace {

constexpr double longest_between_looks = 1.0;  // [s]

}  // namespace

void RowWait::wrote(std::uint64_t sequence) {
  if (rows_.empty()) waited_ = 0.0, looks_ = 0;
  rows_.push_back(sequence > 0 ? sequence : std::numeric_limits<std::uint64_t>::max());
}

bool RowWait::look(std::uint64_t on_disk, double now) {
  const std::uint64_t before = stored_;
  for (; !rows_.empty() && rows_.front() <= on_disk; rows_.pop_front()) ++stored_;
  if (stored_ != before) waited_ = 0.0, looks_ = 0;
  if (waits()) waited_ += looks_++ > 0 ? std::min(now - looked_, longest_between_looks) : 0.0;
  looked_ = now;
  return stored_ != before;
}

}  // namespace tumble::conduct
