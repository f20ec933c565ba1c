#pragma once

#include <set>
#include <string>
#include <vector>

#include "tumble/archive/schema/chain.hpp"
#include "tumble/archive/storage/packing.hpp"
#include "tumble/archive/transfer.hpp"

namespace tumble::transfer {

/// From where to where, and who does it.
struct Way {
  database::Database& from;
  database::Database& to;
  std::string who, when, origin;  ///< origin: words for the event `import`
};

/// Copies what `to` does not have of a chain, within a transaction of `to`.
void copy_chain(const Way& way, const std::string& chain, Transferred& done);

/// SHA-256 of the files and certificates that events of a chain brought.
std::set<std::string> files_of_chain(database::Database& database, const std::string& chain);

/// Copies a file that is kept, and compares it with its SHA-256. Returns whether it was new.
bool copy_file(const storage::Place& from, const storage::Place& to, const std::string& sha256);

}  // namespace tumble::transfer
