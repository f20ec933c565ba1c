#pragma once

#include <fmt/format.h>

#include <functional>
#include <string>

#include "tumble/archive/archive.hpp"
#include "tumble/archive/database/database.hpp"
#include "tumble/archive/storage/packing.hpp"
#include "tumble/units/error.hpp"

namespace tumble::schema {

/// Parts of an open archive.
struct OpenArchive {
  std::string address, folder;  ///< of the files; empty: they lie in the database
  database::Database database;
  storage::Place files() { return {folder, &database}; }
};
OpenArchive& opened(const Archive& archive);

/// Address for messages: without a password.
std::string shown_address(const std::string& address);

/// Makes the tables of a new archive in a database without tables. Given: folder, act as of make_archive().
/// Throws database::Refusal; Error::bad_input where there is an archive already.
void make_tables(const std::string& address, const std::string& folder, const ArchiveAct& act);

/// Makes a database in a file of another name in the same folder, and gives it its name when it is whole: of two
/// programs one has the name, and the file of the other one is removed.
///
/// Given     taken  the refusal where another file has the name, before or after
/// Throws    Error::bad_input with `taken`; Error::bad_file for what a database refuses
void make_whole(const std::string& path, const std::string& taken,
                const std::function<void(const std::string& file)>& make);

/// Does `work`; what the database refuses becomes an error that names the archive.
template <typename Work>
auto guarded(const std::string& address, const Work& work) {
  try {
    return work();
  } catch (const database::Refusal& refusal) {
    throw Error(Error::Kind::bad_file, say("archive '{}': {}", shown_address(address), refusal.text));
  }
}

}  // namespace tumble::schema
