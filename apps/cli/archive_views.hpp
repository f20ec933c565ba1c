#pragma once

#include <string>
#include <vector>

#include "terminal.hpp"
#include "tumble/archive/archive_json.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/notes.hpp"
#include "tumble/archive/verify.hpp"
#include "tumble/tasks/recompute.hpp"

namespace tumble::cli {

/// What an archive answers, as text for people; archive_json.hpp has it for programs.
std::string units_text(const std::vector<ArchivedUnit>& units, const Terminal& terminal);
std::string record_text(const UnitRecord& record, const Terminal& terminal);
std::string run_text(const RunRecord& record, const Terminal& terminal);
std::string due_text(const std::vector<DueCalibration>& due, const std::vector<DueUnit>& units,
                     const std::string& today, const Terminal& terminal);
std::string check_text(const ArchiveCheck& check, const Terminal& terminal);
std::string recomputation_text(const Recomputation& again, const Terminal& terminal);
std::string recomputation_json(const Recomputation& again);

}  // namespace tumble::cli
