#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tumble/archive/archive.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble {

/// Counts and problems that verify_archive() found.
struct ArchiveCheck {
  std::size_t chains = 0, events = 0, results = 0, files = 0;
  Problems problems;  ///< empty: nothing has changed
  /// Certificate numbers that several results share, a sentence each: from before the archive refused that, or brought
  /// by an import. Nothing has changed because of them, so they are no problems.
  std::vector<Sentence> shared_numbers;
  /// SHA-256 over the last event of every chain: written down elsewhere, it shows later that no chain was cut short.
  std::string heads;
};

/// Reads everything and compares: every event with its chain, every row with the event that brought it, every result
/// with its SHA-256, every stored file with its own. A row that no event brought is a problem too.
///
/// Throws    Error::bad_file where the database cannot be read at all
ArchiveCheck verify_archive(const Archive& archive, const Progress& progress = {});

}  // namespace tumble
