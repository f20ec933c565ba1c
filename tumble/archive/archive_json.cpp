#include "tumble/archive/archive_json.hpp"

#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"

namespace tumble {

namespace {

using Json = nlohmann::ordered_json;

std::string written(const Json& json) { return json_text(json, 1) + "\n"; }

Json steps_json(const std::vector<ArchivedStep>& steps) {
  Json all = Json::array();
  for (const auto& one : steps)
    all.push_back({{"number", one.number},
                   {"time", one.when},
                   {"by", one.who},
                   {"what", one.action},
                   {"which", one.subject},
                   {"why", one.reason},
                   {"detail", one.detail}});
  return all;
}

}  // namespace

std::string units_json(const std::vector<ArchivedUnit>& units) {
  Json all = Json::array();
  for (const auto& unit : units)
    all.push_back({{"model", unit.name.model},
                   {"serial", unit.name.serial},
                   {"results", unit.results},
                   {"first", unit.first},
                   {"last", unit.last}});
  return written(all);
}

std::string record_json(const UnitRecord& record) {
  Json json{{"model", record.name.model}, {"serial", record.name.serial}};
  for (const char* const name : {"results", "runs", "files", "certificates", "signatures", "events"})
    json[name] = Json::array();
  for (const auto& one : record.results)
    json["results"].push_back({{"sha256", one.sha256},
                               {"method", one.method},
                               {"title", one.title},
                               {"verdict", one.verdict},
                               {"by", one.who},
                               {"begun", one.begun},
                               {"ended", one.ended},
                               {"archived", one.archived},
                               {"tumble", one.program_version},
                               {"run", one.run},
                               {"simulated", one.simulated},
                               {"replaced_by", one.replaced_by},
                               {"reason", one.correction}});
  for (const auto& one : record.runs)
    json["runs"].push_back({{"id", one.id},
                            {"title", one.title},
                            {"station", one.station},
                            {"slot", one.slot},
                            {"operator", one.who},
                            {"started", one.started},
                            {"ended", one.ended},
                            {"ending", one.ending}});
  for (const auto& one : record.files)
    json["files"].push_back({{"sha256", one.sha256},
                             {"role", one.role},
                             {"name", one.name},
                             {"bytes", one.bytes},
                             {"run", one.run},
                             {"slot", one.slot}});
  for (const auto& one : record.certificates)
    json["certificates"].push_back({{"number", one.number},
                                    {"format", one.format},
                                    {"sha256", one.sha256},
                                    {"result", one.result},
                                    {"issued_by", one.issued_by},
                                    {"issued", one.issued}});
  for (const auto& one : record.signatures)
    json["signatures"].push_back({{"number", one.number},
                                  {"of", one.kind},
                                  {"sha256", one.sha256},
                                  {"meaning", one.meaning},
                                  {"by", one.who},
                                  {"time", one.when},
                                  {"why", one.why},
                                  {"problem", one.problem}});
  json["events"] = steps_json(record.steps);
  return written(json);
}

std::string run_json(const RunRecord& record) {
  const auto& run = record.run;
  Json json{{"id", run.id},           {"title", run.title}, {"station", run.station}, {"operator", run.who},
            {"started", run.started}, {"ended", run.ended}, {"ending", run.ending}};
  json["units"] = Json::array();
  for (const auto& [slot, unit] : record.units)
    json["units"].push_back({{"slot", slot}, {"model", unit.model}, {"serial", unit.serial}});
  json["equipment"] = Json::array();
  for (const auto& [name, certificate] : record.equipment)
    json["equipment"].push_back({{"equipment", name}, {"certificate", certificate}});
  json["events"] = steps_json(record.steps);
  return written(json);
}

std::string due_json(const std::vector<DueCalibration>& due, const std::vector<DueUnit>& units) {
  Json all{{"equipment", Json::array()}, {"units", Json::array()}};
  for (const auto& one : due)
    all["equipment"].push_back({{"due", one.due},
                                {"equipment", one.equipment},
                                {"certificate", one.certificate},
                                {"laboratory", one.laboratory}});
  for (const auto& one : units)
    all["units"].push_back(
        {{"due", one.due}, {"model", one.unit.model}, {"serial", one.unit.serial}, {"last_result", one.last}});
  return written(all);
}

std::string check_json(const ArchiveCheck& check) {
  return written({{"chains", check.chains},
                  {"events", check.events},
                  {"results", check.results},
                  {"files", check.files},
                  {"problems", check.problems},
                  {"shared_numbers", check.shared_numbers},
                  {"heads", check.heads}});
}

}  // namespace tumble
