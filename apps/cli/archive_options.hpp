#pragma once

#include <optional>
#include <string>

#include "tumble/archive/deposit.hpp"
#include "tumble/exchange/certificate.hpp"
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
/// Where one is named: opened before any work is done, so that what is wrong with it is said at once. Nothing is
/// archived where neither the option nor the variable names one.
std::optional<Archive> optional_archive(const ArchiveOptions& options);
/// What to do where the unit is not known: refused where --archive asks for it, else a note, and nothing is archived.
bool unit_is_known(const UnitName& unit, const ArchiveOptions& options, const Terminal& terminal);
/// Who, now, why. Without --by it is the name under which the user is logged in.
ArchiveAct act_of(const ArchiveOptions& options);

/// MODEL/SERIAL, or nothing. Throws Error::bad_input.
UnitName unit_name(const std::string& text);

/// What an archive keeps of the equipment of a certificate.
std::vector<EquipmentDeposit> equipment_deposits(const std::vector<Equipment>& equipment);

/// What a deposit changed, as a note.
void note_deposited(const Terminal& terminal, const Deposited& done);

/// UTC now, "2026-11-24T09:00:00Z"; the day so many seconds later, "2026-12-24".
std::string utc_now();
std::string utc_day(double seconds);

}  // namespace tumble::cli
