#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tumble/archive/deposit.hpp"
#include "tumble/core/progress.hpp"

/// Transfer of everything about a unit from one archive to another.
namespace tumble {

struct Transferred {
  std::size_t events = 0, results = 0, files = 0;  ///< that were new
  std::size_t known = 0;                           ///< events that were there already, or whose rows were
};

/// Writes everything about one unit into one file: results, recordings, plans, certificates, its runs with their
/// equipment, and the events. The file is an archive of its own, whose files lie within it: every function of this
/// module reads it.
///
/// Given     path  a file that is not there
/// Throws    Error::bad_input where it is there; Error::bad_file with all files that are missing or have changed
Transferred export_unit(const Archive& archive, const UnitName& unit, const std::string& path, const ArchiveAct& act);

/// Puts everything that another archive holds into this one. Chains that go on from what is here keep their events as
/// they are; where both have gone on, the new events follow an event `import` with their own time and person. Doing it
/// again changes nothing.
///
/// Given     address  of the other archive: a file of export_unit(), or any archive
/// Throws    Error::bad_data with what verify_archive() finds in it; Error::bad_file
Transferred import_archive(Archive& archive, const std::string& address, const ArchiveAct& act,
                           const Progress& progress = {});

}  // namespace tumble
