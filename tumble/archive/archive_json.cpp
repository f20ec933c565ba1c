#include "tumble/archive/archive_json.hpp"

#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/report/members.hpp"

namespace tumble {

template <class Visitor>
void members(Visitor& visit, const ArchivedStep& one) {
  visit("number", one.number)("time", one.when)("by", one.who)("what", one.action)("which", one.subject);
  visit("why", one.reason)("detail", one.detail);
}

template <class Visitor>
void members(Visitor& visit, const ArchivedResult& one) {
  visit("sha256", one.sha256)("method", one.method)("title", one.title)("verdict", one.verdict)("by", one.who);
  visit("begun", one.begun)("ended", one.ended)("archived", one.archived)("tumble", one.program_version);
  visit("run", one.run)("simulated", one.simulated)("replaced_by", one.replaced_by)("reason", one.correction);
}

template <class Visitor>
void members(Visitor& visit, const ArchivedRun& one) {
  visit("id", one.id)("title", one.title)("station", one.station)("slot", one.slot)("operator", one.who);
  visit("started", one.started)("ended", one.ended)("ending", one.ending);
}

template <class Visitor>
void members(Visitor& visit, const ArchivedFile& one) {
  visit("sha256", one.sha256)("role", one.role)("name", one.name)("bytes", one.bytes)("run", one.run)("slot", one.slot);
}

template <class Visitor>
void members(Visitor& visit, const ArchivedCertificate& one) {
  visit("number", one.number)("format", one.format)("sha256", one.sha256)("result", one.result);
  visit("issued_by", one.issued_by)("issued", one.issued);
}

template <class Visitor>
void members(Visitor& visit, const Signature& one) {
  visit("number", one.number)("of", one.kind)("sha256", one.sha256)("meaning", one.meaning)("by", one.who);
  visit("time", one.when)("why", one.why)("problem", one.problem);
}

template <class Visitor>
void members(Visitor& visit, const UnitRecord& record) {
  visit("model", record.name.model)("serial", record.name.serial)("results", record.results)("runs", record.runs);
  visit("files", record.files)("certificates", record.certificates)("signatures", record.signatures);
  visit("events", record.steps);
}

namespace {

using Json = nlohmann::ordered_json;

std::string written(const Json& json) { return json_text(json, 1) + "\n"; }

template <class Part>
Json json_of(const Part& part) {
  Json json = Json::object();
  MembersToJson visit{JsonObject(&json)};
  visit("all", part);
  return json["all"];
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

std::string record_json(const UnitRecord& record) { return written(json_of(record)); }

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
  json["events"] = json_of(record.steps);
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
  std::vector<std::string> shared;
  for (const auto& one : check.shared_numbers) shared.push_back(one.text());
  return written({{"chains", check.chains},
                  {"events", check.events},
                  {"results", check.results},
                  {"files", check.files},
                  {"problems", texts_of(check.problems)},
                  {"shared_numbers", shared},
                  {"heads", check.heads}});
}

}  // namespace tumble
