#pragma once

#include <string>
#include <vector>

#include "tumble/archive/history.hpp"
#include "tumble/archive/notes.hpp"
#include "tumble/archive/verify.hpp"

/// Answers of an archive as JSON: the command line, Python and the workbench give the same.
namespace tumble {

std::string units_json(const std::vector<ArchivedUnit>& units);
std::string record_json(const UnitRecord& record);
std::string run_json(const RunRecord& record);
std::string due_json(const std::vector<DueCalibration>& due, const std::vector<DueUnit>& units);
std::string check_json(const ArchiveCheck& check);

}  // namespace tumble
