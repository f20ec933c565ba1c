#pragma once

#include <string>
#include <vector>

namespace tumble::testing {

/// Where a case of the suite may make an archive.
struct ArchivePlace {
  std::string address;  ///< of an archive that is not there yet
  std::string folder;   ///< scratch
};

/// A case that holds on every database. It checks by EXPECT and ASSERT.
struct ArchiveCase {
  const char* name;
  void (*run)(const ArchivePlace&);
};

/// All cases: the SQLite tests run each by itself, the PostgreSQL test all of them on one server.
const std::vector<ArchiveCase>& archive_cases();

}  // namespace tumble::testing
