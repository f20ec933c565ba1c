#pragma once

#include <fmt/format.h>

#include <string>

#include "tumble/archive/archive.hpp"
#include "tumble/archive/database/database.hpp"
#include "tumble/archive/storage/packing.hpp"
#include "tumble/units/error.hpp"

namespace tumble::schema {

/// What an open archive is made of.
struct OpenArchive {
  std::string address, folder;  ///< of the files; empty: they lie in the database
  database::Database database;
  storage::Place files() { return {folder, &database}; }
};
OpenArchive& opened(const Archive& archive);

/// Address for messages: without a password.
std::string shown_address(const std::string& address);

/// Does `work`; what the database refuses becomes an error that names the archive.
template <typename Work>
auto guarded(const std::string& address, const Work& work) {
  try {
    return work();
  } catch (const database::Refusal& refusal) {
    throw Error(Error::Kind::bad_file, fmt::format("archive '{}': {}", shown_address(address), refusal.text));
  }
}

}  // namespace tumble::schema
