#pragma once

#include <string>

#include "tumble/archive/testing/samples.hpp"
#include "tumble/archive/testing/suite.hpp"
#include "tumble/units/testing/asserts.hpp"

/// Helpers that the cases of the suite have in common.
namespace tumble::testing {

Archive new_archive(const ArchivePlace& place);
std::string write_file(const ArchivePlace& place, const std::string& name, const std::string& text);
/// Three results of one unit, one of another, and the recording of the first.
Deposit fleet(const ArchivePlace& place);
void expect_sound(const Archive& archive);
/// Problems that verify_archive() finds, without the triggers that allow_changes() switches off.
std::vector<std::string> changes_of(const Archive& archive);
/// So that rows of a table can be changed behind the back of the archive.
void allow_changes(const Archive& archive, const std::string& table);

/// Cases of the other files of the suite.
std::vector<ArchiveCase> cases_of_changes();
std::vector<ArchiveCase> cases_of_names_and_notes();
std::vector<ArchiveCase> cases_of_transfer();
std::vector<ArchiveCase> cases_of_signatures();
std::vector<ArchiveCase> cases_of_certificates();

}  // namespace tumble::testing
