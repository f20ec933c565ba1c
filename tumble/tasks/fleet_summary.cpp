#include "tumble/tasks/fleet_summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "tumble/archive/past_results.hpp"
#include "tumble/archive/statistics.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/tasks/fleet/limits.hpp"
#include "tumble/tasks/fleet/merge.hpp"
#include "tumble/tasks/fleet/risk.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Severity = Finding::Severity;

constexpr std::size_t fewest_units = 3;
/// Of a result whose recordings have no date: it counts as one of this day.
constexpr const char* no_date = "2000-01-01T00:00:00Z";

/// The folder with the results of a fleet: those of the version that fleet.json names, or the folder itself.
fs::path folder_of_results(const std::string& folder) {
  std::error_code failed;
  if (!fs::is_directory(folder, failed)) throw Error(Error::Kind::bad_input, say("{}: is not a folder", Name{folder}));
  const fs::path document = fs::path(folder) / "fleet.json";
  if (!fs::exists(document)) return folder;
  const Json json = Json::parse(read_text_file(document.string()), nullptr, false);
  if (!json.is_object() || !json.contains("tumble") || !json["tumble"].is_string())
    throw Error(Error::Kind::bad_file, say("{}: is not what tumble fleet run writes", Name{document.string()}));
  return fs::path(folder) / "results" / json["tumble"].get<std::string>();
}

std::vector<std::string> files_below(const fs::path& folder) {
  std::vector<std::string> files;
  std::error_code failed;
  for (fs::recursive_directory_iterator at(folder, failed), end; at != end && !failed; at.increment(failed))
    if (at->is_regular_file() && at->path().extension() == ".json") files.push_back(at->path().string());
  std::ranges::sort(files);
  return files;
}

/// The keys in the logs of a fleet that the last line about a recording names: an earlier result of a recording that
/// has changed since is not one of the table. Nothing where the folder has no logs.
std::optional<std::set<std::string>> keys_of_the_table(const fs::path& folder) {
  std::vector<fs::path> logs;
  std::error_code failed;
  for (fs::directory_iterator at(folder / "log", failed), end; !failed && at != end; at.increment(failed))
    if (at->path().filename().string().starts_with("run-")) logs.push_back(at->path());
  if (logs.empty()) return std::nullopt;
  std::ranges::sort(logs);
  std::map<std::string, std::string> last;
  for (const auto& log : logs) {
    std::istringstream lines(read_text_file(log.string()));
    for (std::string line; std::getline(lines, line);) {
      const Json json = Json::parse(line, nullptr, false);  // a crash may have cut the last one
      if (!json.is_object() || !json.contains("status") || !json.contains("recording")) continue;
      const Json key = json.value("key", Json());
      last[json["recording"].get<std::string>()] = key.is_string() ? key.get<std::string>() : "";
    }
  }
  std::set<std::string> keys;
  for (const auto& [recording, key] : last) keys.insert(key);
  return keys;
}

/// The files of results that count.
std::vector<std::string> results_in(const std::string& folder) {
  auto files = files_below(folder_of_results(folder));
  if (const auto keys = keys_of_the_table(folder))
    std::erase_if(files, [&](const std::string& file) { return !keys->contains(fs::path(file).stem().string()); });
  return files;
}

/// The results of a fleet, each read once.
struct FleetResults {
  std::string method, model;
  std::vector<SummarisedResult> results;
  std::set<std::string> known;  ///< their SHA-256
  std::size_t units = 0;
  std::vector<std::string> parameters;      ///< in the order in which they first occur
  std::vector<std::string> same_recording;  ///< serial numbers whose result has the recording of another one
};

std::string inputs_of(const Json& json) {
  std::vector<std::string> inputs;
  for (const auto& input : json["provenance"]["inputs"]) inputs.push_back(input["sha256"].get<std::string>());
  std::ranges::sort(inputs);
  return fmt::format("{}", fmt::join(inputs, " "));
}

/// Reads one result, unless its recording is that of another one.
void take(const std::string& file, std::set<std::string>& recordings, FleetResults& fleet, Problems& problems) try {
  std::string text = read_text_file(file);
  const Json json = Json::parse(text);
  const auto method = json.at("method").get<std::string>();
  if (!fleet.method.empty() && method != fleet.method)
    throw Error(Error::Kind::bad_input, say("{}: is a result of {}, and others are of {}: results of one method "
                                            "are expected",
                                            Name{file}, Name{method}, Name{fleet.method}));
  fleet.method = method;
  const auto& instrument = json.at("instrument");
  UnitName unit{instrument.value("model", ""), instrument.value("serial", "")};
  if (unit.model.empty()) unit.model = method;
  fleet.model = unit.model;
  if (unit.serial.empty())
    throw Error(Error::Kind::bad_input,
                say("{}: has no serial number: tumble fleet run takes it from the file's name", Name{file}));
  if (const auto inputs = inputs_of(json); !inputs.empty() && !recordings.insert(inputs).second) {
    fleet.same_recording.push_back(unit.serial);
    return;
  }
  for (const auto& parameter : json.at("parameters")) {
    const auto name = parameter.at("name").get<std::string>();
    if (std::ranges::find(fleet.parameters, name) == fleet.parameters.end()) fleet.parameters.push_back(name);
  }
  ++fleet.units;
  auto summary = summary_of_result({.json = std::move(text), .file = file, .unit = unit}, no_date, problems);
  if (fleet.known.insert(summary.sha256).second) fleet.results.push_back(std::move(summary));
} catch (const Json::exception&) {
  throw Error(Error::Kind::bad_file, say("{}: is not a result of tumble identify", Name{file}));
}

FleetResults read_fleet(const std::vector<std::string>& files) {
  FleetResults fleet;
  std::set<std::string> recordings;
  Problems problems;
  for (const auto& file : files) take(file, recordings, fleet, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return fleet;
}

/// The parameters asked for, in their order. Throws Error::bad_input with all that no result has.
std::vector<std::string> chosen(const FleetResults& fleet, const std::vector<std::string>& wanted,
                                const fleet::LimitsByName& limits) {
  Problems problems;
  const auto check = [&](const std::string& name) {
    if (std::ranges::find(fleet.parameters, name) == fleet.parameters.end())
      problems.push_back(say("no result has the parameter '{}'{}", name, did_you_mean(name, fleet.parameters)));
  };
  std::set<std::string> asked(wanted.begin(), wanted.end());
  for (const auto& [name, both] : limits) asked.insert(name);
  for (const auto& name : asked) check(name);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return wanted.empty() ? fleet.parameters : wanted;
}

}  // namespace

Estimate summarise_fleet(const std::string& folder, const std::vector<std::string>& parameters, const Sets& sets) {
  const auto limits = fleet::limits_by_name(sets);
  const auto files = results_in(folder);
  if (files.empty())
    throw Error(Error::Kind::bad_input,
                say("{}: holds no results: tumble fleet run PLAN RECORDINGS -o FOLDER makes them", Name{folder}));
  const FleetResults found = read_fleet(files);
  const auto names = chosen(found, parameters, limits);
  Estimate all;
  all.method = "fleet_summary";
  all.title = fmt::format("{} units: {}", found.units, found.method);
  all.instrument_model = found.model == found.method ? "" : found.model;
  if (found.units < fewest_units)
    throw Error(Error::Kind::bad_data, say("{}: {} units have a result of their own, and a summary needs {} or "
                                           "more",
                                           Name{folder}, found.units, fewest_units));
  fleet::Overview overview;
  for (const auto& name : names) try {
      const PastResults results = past_results(found.results, name, found.model);
      const ParameterLimits both = fleet::limits_in(limits, name, results.over.shown);
      fleet::add_parameter(results, {name, found.model, both}, overview, all);
    } catch (const Error& error) {
      if (error.kind != Error::Kind::bad_data) throw;
      all.findings.push_back({Severity::info, "parameter_not_summarised", {{"reason", error.problems.front()}}, name});
    }
  if (all.parameters.empty())
    throw Error(Error::Kind::bad_data,
                say("{}: no parameter can be summarised: of each there are fewer than three units", Name{folder}));
  fleet::finish(overview, all);
  if (!found.same_recording.empty())
    all.findings.push_back({Severity::warning,
                            "same_recording_of_units",
                            {{"units", fmt::format("{}", fmt::join(found.same_recording, ", "))}}});
  all.provenance.settings["units"] = fmt::format("{}", found.units);
  all.fit.observations = found.units;
  return all;
}

}  // namespace tumble
