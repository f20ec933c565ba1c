#pragma once

#include <cstddef>

#include "tumble/recorder/live_store/marks_of_journal.hpp"

namespace tumble::testing {

/// Marks that a store has which ends with the last row that was added.
class MarksSoFar {
 public:
  void add(double time, const RunRow& row) { reader_.add(time, row); }  ///< time [s]
  std::size_t count() const { return reader_.marks().size(); }

 private:
  live_store::JournalReader reader_;
};

}  // namespace tumble::testing
