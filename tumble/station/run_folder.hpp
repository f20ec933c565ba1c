#pragma once

#include <memory>
#include <string>

#include "tumble/core/plan.hpp"
#include "tumble/recorder/recorder.hpp"
#include "tumble/station/executive.hpp"
#include "tumble/units/error.hpp"

/// The folder of a run: plan.toml, station.toml, the live store, and after sealing the recording.
namespace tumble {

/// Makes it, with the texts of plan and station. Throws Error::bad_input where it is there already, Error::bad_file
/// where it cannot be made: then nothing of it remains.
void make_run_folder(const std::string& folder, const Plan& plan, const Station& station);

/// Writes a text file into it. Throws Error::bad_file.
void write_in_run(const std::string& folder, const std::string& name, const std::string& text);

/// Removes the folder of a run that has not begun; one without a recording would be taken for a run.
void forget_run(const std::string& folder);

/// `error` as the reason why a run was not begun, or does not go on.
Error not_begun(const Error& error, bool resume);

/// Course of a plan at a station, for these units.
std::shared_ptr<const Course> course_of(const Plan& plan, const Station& station,
                                        const std::map<std::string, std::string>& units);

/// Whether a run may be carried on with this plan and this station, of which its store says what they were at its
/// begin. `named`: the user has named the station, which may be another one. Throws Error::bad_input with all that has
/// changed.
void check_carried_on(const std::map<std::string, std::string>& facts, const Plan& plan, const Station& station,
                      bool named);

/// Facts about the run that its store keeps: title, units, operator, hashes.
void note_facts(Recorder& recorder, const Plan& plan, const Course& course, const std::string& who);

/// That a rig of this kind ("virtual", "rehearsed") was played, and no instrument measured: with the seed, as a simulation
/// states it, every result of the recording is a specimen.
void note_played(Recorder& recorder, const std::string& rig, std::uint64_t seed);

}  // namespace tumble
