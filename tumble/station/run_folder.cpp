#include "tumble/station/run_folder.hpp"

#include <filesystem>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace fs = std::filesystem;

void write_in_run(const std::string& folder, const std::string& name, const std::string& text) {
  write_file_atomically((fs::path(folder) / name).string(), text);
}

void forget_run(const std::string& folder) {
  std::error_code ignored;
  fs::remove_all(folder, ignored);
}

Error not_begun(const Error& error, bool resume) {
  auto problems = error.problems;
  for (Problem& problem : problems)
    problem = within(resume ? Sentence("the run does not go on, and what it has recorded is kept")
                            : Sentence("the run was not begun"),
                     problem);
  return Error(error.kind, problems);
}

void make_run_folder(const std::string& folder, const Plan& plan, const Station& station) {
  std::error_code problem;
  if (fs::exists(folder, problem))
    throw Error(Error::Kind::bad_input, say("'{}' is there already: a run is never written over another one", folder));
  if (!fs::create_directories(folder, problem))
    throw not_begun(
        Error(Error::Kind::bad_file, say("cannot make the folder '{}': {}", folder, system_reason(problem))), false);
  try {
    if (plan.text) write_in_run(folder, "plan.toml", *plan.text);
    if (!station.text.empty()) write_in_run(folder, "station.toml", station.text);
  } catch (const Error& error) {
    forget_run(folder);
    throw not_begun(error, false);
  }
}

std::shared_ptr<const Course> course_of(const Plan& plan, const Station& station,
                                        const std::map<std::string, std::string>& units) {
  auto course = std::make_shared<Course>();
  course->station = station;
  course->schedule = plan.schedule;
  course->until = stopping_rules(plan);
  course->all_units = station.all_units;
  course->prompt_deadline = station.answer_within;
  for (const auto& [slot, serial] : units) course->units.push_back({slot, serial});
  return course;
}

void check_carried_on(const std::map<std::string, std::string>& facts, const Plan& plan, const Station& station,
                      bool named) {
  Problems problems;
  const auto differs = [&](const char* name, const std::string& now) {
    const auto then = facts.find(name);
    return then != facts.end() && then->second != now;
  };
  if (differs("plan_sha256", plan.sha256))
    problems.push_back("the plan in the folder of the run has been changed since the run began: begin a new run");
  if (!named && differs("station_sha256", station.sha256))
    problems.push_back(
        say("the station file '{}' has been changed since the run began: name it with --station to use it as it is now",
            station.file));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, std::move(problems));
}

void note_facts(Recorder& recorder, const Plan& plan, const Course& course, const std::string& who) {
  recorder.set("title", plan.title);
  recorder.set(std::string(plan_fact), plan.sha256);
  recorder.set("station", course.station.name);
  if (!course.station.text.empty())  // else it was made for the plan
    recorder.set("station_file", std::filesystem::absolute(course.station.file).string());
  recorder.set("station_sha256", course.station.sha256);
  recorder.set("operator", who);
  for (const UnitUnderTest& unit : course.units) recorder.set(std::string(unit_fact) + " " + unit.slot, unit.serial);
}

void note_played(Recorder& recorder, const std::string& rig, std::uint64_t seed) {
  recorder.set("rig", rig);
  recorder.set(std::string(simulated_fact), "yes");
  recorder.set(std::string(seed_fact), std::to_string(seed));
}

}  // namespace tumble
