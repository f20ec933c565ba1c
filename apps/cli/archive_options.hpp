#pragma once

#include <string>

#include "tumble/archive/deposit.hpp"
#include "verbs.hpp"

namespace tumble::cli {

/// The options of every verb that puts something into an archive.
struct ArchiveOptions {
  std::string address, who, why;
};

Argument archive_argument(ArchiveOptions& options);
Argument by_argument(ArchiveOptions& options);

/// The address that --archive or the environment variable TUMBLE_ARCHIVE gives; empty: none.
std::string archive_address(const ArchiveOptions& options);
/// The archive that --archive or TUMBLE_ARCHIVE names. Throws Error::bad_input without one.
Archive open_archive(const ArchiveOptions& options);
/// Who, now, why. Without --by it is the name under which the user is logged in.
ArchiveAct act_of(const ArchiveOptions& options);

/// MODEL/SERIAL, or nothing. Throws Error::bad_input.
UnitName unit_name(const std::string& text);

/// What a deposit changed, as a note.
void note_deposited(const Terminal& terminal, const Deposited& done);

/// UTC now, "2026-11-24T09:00:00Z"; the day so many seconds later, "2026-12-24".
std::string utc_now();
std::string utc_day(double seconds);

}  // namespace tumble::cli
