#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "tumble/archive/deposits/parts.hpp"
#include "tumble/archive/deposits/sources.hpp"
#include "tumble/archive/storage/packing.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/exchange/certificate_number.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::deposits {

namespace {

using database::Bytes;
using database::number_or_nothing;
using database::Row;
using database::text_or_nothing;
using schema::Change;

bool is_there(Change& change, const std::string& table, const std::string& column, const std::string& value) {
  return !change.database().ask(fmt::format("SELECT 1 FROM {} WHERE {} = ?", table, column), {value}).empty();
}

/// The worst of the verdicts, on one parameter or on all of them; empty: there is none.
std::string verdict_of(const Estimate& estimate, const std::string& parameter = {}) {
  using Outcome = Verdict::Outcome;
  std::string worst;
  for (const auto& verdict : estimate.verdicts) {
    if (!parameter.empty() && verdict.parameter != parameter) continue;
    if (verdict.outcome == Outcome::fail) return "fail";
    if (verdict.outcome == Outcome::undecided || worst.empty())
      worst = verdict.outcome == Outcome::undecided ? "undecided" : "pass";
  }
  return worst;
}

std::vector<Row> parameter_rows(const Estimate& estimate, std::int64_t id, std::int64_t unit, std::int64_t moment) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const Parameter& parameter = estimate.parameters[i];
    const auto [private_sd, sources] = sources_of(estimate, i);
    rows.push_back({id, static_cast<std::int64_t>(i), parameter.name, text_or_nothing(parameter.symbol),
                    number_or_nothing(parameter.value), number_or_nothing(standard_uncertainty(estimate, i)),
                    number_or_nothing(parameter.degrees_of_freedom), parameter.unit.text(), unit, moment,
                    number_or_nothing(private_sd), sources, text_or_nothing(verdict_of(estimate, parameter.name))});
  }
  return rows;
}

std::vector<Row> input_rows(const Estimate& estimate, std::int64_t id) {
  std::vector<Row> rows;
  std::int64_t place = 0;
  for (const auto& [role, sha256, name] : inputs_of(estimate)) rows.push_back({id, place++, role, sha256, name});
  return rows;
}

Row result_row(const Change& change, const ReadResult& result, std::int64_t unit, std::int64_t moment) {
  const Estimate& estimate = result.estimate;
  const auto& plans = estimate.provenance.plans;
  const auto& seed = estimate.provenance.seed;
  return {schema::number_of(result.sha256),
          result.sha256,
          unit,
          text_or_nothing(result.deposit->run),
          estimate.method,
          estimate.title,
          text_or_nothing(plans.empty() ? std::string() : plans.front().sha256),
          text_or_nothing(result.deposit->station_sha256),
          result.program_version,
          text_or_nothing(seed ? fmt::format("{}", *seed) : std::string()),
          text_or_nothing(verdict_of(estimate)),
          text_or_nothing(result.begun),
          text_or_nothing(result.ended),
          change.when(),
          change.who(),
          moment,
          static_cast<std::int64_t>(result.deposit->json.size()),
          Bytes{storage::packed(result.deposit->json)}};
}

}  // namespace

std::int64_t moment_of(const std::string& ended, const std::string& archived) {
  constexpr std::int64_t second = 1'000'000'000;
  const auto time = parse_iso_time(ended.empty() ? archived : ended);
  return time ? *time / second : 0;
}

std::string sha256_of_unit(const UnitName& unit) { return sha256_of(unit.model + std::string(1, '\0') + unit.serial); }

std::string equipment_id(const EquipmentDeposit& equipment) {
  return equipment.serial.empty() ? equipment.name : equipment.name + "/" + equipment.serial;
}

std::int64_t unit_row(Change& change, const UnitName& unit) {
  const std::string sha256 = sha256_of_unit(unit);
  const std::int64_t id = schema::number_of(sha256);
  if (change.database().ask("SELECT 1 FROM units WHERE id = ?", {id}).empty())
    change.append(schema::chain_of_unit(unit.model, unit.serial), {"unit", sha256, {}, {}},
                  {{&schema::units, {{id, unit.model, unit.serial, database::Value(), database::Value()}}}});
  return id;
}

bool put_result(Change& change, const ReadResult& result) {
  const std::int64_t id = schema::number_of(result.sha256);
  if (!change.database().ask("SELECT 1 FROM results WHERE id = ?", {id}).empty()) return false;
  const std::int64_t unit = unit_row(change, result.unit);
  const std::int64_t moment = moment_of(result.ended, change.when());
  const std::string chain = schema::chain_of_unit(result.unit.model, result.unit.serial);
  change.append(chain, {"result", result.sha256, {}, result.deposit->run},
                {{&schema::results, {result_row(change, result, unit, moment)}},
                 {&schema::parameters, parameter_rows(result.estimate, id, unit, moment)},
                 {&schema::inputs, input_rows(result.estimate, id)}});
  return true;
}

bool put_file(Change& change, const FileDeposit& file, const std::string& sha256, std::int64_t bytes) {
  if (is_there(change, "files", "sha256", sha256)) return false;
  const bool of_run = file.unit.serial.empty();
  Row row{sha256, {}, text_or_nothing(file.run), text_or_nothing(file.slot), file.role, file.name, bytes};
  if (!of_run) row[1] = unit_row(change, file.unit);
  const std::string chain =
      of_run ? schema::chain_of_run(file.run) : schema::chain_of_unit(file.unit.model, file.unit.serial);
  change.append(chain, {"file", sha256, {}, file.role}, {{&schema::files, {row}}});
  return true;
}

bool put_equipment(Change& change, const EquipmentDeposit& equipment) {
  const std::string id = equipment_id(equipment), chain = schema::chain_of_equipment(id);
  bool is_new = false;
  if (!is_there(change, "equipment", "id", id)) {
    change.append(chain, {"equipment", id, {}, {}},
                  {{&schema::equipment,
                    {{id, equipment.name, text_or_nothing(equipment.maker), text_or_nothing(equipment.model),
                      text_or_nothing(equipment.serial), text_or_nothing(equipment.firmware),
                      text_or_nothing(equipment.location)}}}});
    is_new = true;
  }
  if (equipment.certificate.empty()) return is_new;
  const std::string calibration = id + "/" + equipment.certificate;
  if (is_there(change, "calibrations", "id", calibration)) return is_new;
  change.append(
      chain, {"calibration", calibration, {}, equipment.due},
      {{&schema::calibrations,
        {{calibration, id, equipment.certificate, text_or_nothing(equipment.laboratory), text_or_nothing(equipment.due),
          text_or_nothing(equipment.document_sha256), text_or_nothing(equipment.calibrated)}}}});
  return true;
}

bool put_run(Change& change, const RunDeposit& run) {
  if (is_there(change, "runs", "id", run.id)) return false;
  std::vector<Row> slots, rigs;
  std::set<std::string> used;
  for (const auto& [slot, unit] : run.units) slots.push_back({run.id, slot, unit_row(change, unit)});
  for (const auto& one : run.equipment) {
    put_equipment(change, one);
    if (used.insert(equipment_id(one)).second)
      rigs.push_back({run.id, equipment_id(one), text_or_nothing(one.certificate)});
  }
  const std::string chain = schema::chain_of_run(run.id);
  for (const auto& event : run.events)
    change.append_at(chain, {"in run: " + event.action, event.subject, event.reason, event.detail}, event.when,
                     event.who);
  change.append(chain, {"run", run.id, {}, run.ending},
                {{&schema::runs,
                  {{run.id, run.title, text_or_nothing(run.plan_sha256), text_or_nothing(run.station),
                    text_or_nothing(run.station_sha256), text_or_nothing(run.program_version), text_or_nothing(run.who),
                    text_or_nothing(run.started), text_or_nothing(run.ended), text_or_nothing(run.ending)}}},
                 {&schema::run_units, slots},
                 {&schema::run_equipment, rigs}});
  for (const auto& [slot, unit] : run.units)
    change.append(schema::chain_of_unit(unit.model, unit.serial), {"in run", run.id, {}, slot});
  return true;
}

namespace {

/// What a certificate is written as: "html", "dcc", and "html-zh" for other languages.
std::string form_of(const CertificateDeposit& certificate) {
  const std::string format = std::filesystem::path(certificate.path).extension() == ".xml" ? "dcc" : "html";
  const bool english = certificate.language.empty() || certificate.language == "en";
  return english ? format : format + "-" + certificate.language;
}

}  // namespace

Sentence problem_of_number(database::Database& database, const CertificateDeposit& certificate,
                           const std::string& sha256) {
  Sentence problem = problem_of_certificate_number(certificate.number);
  if (!problem.empty()) return problem;
  database.visit(
      "SELECT c.sha256, r.sha256, u.model, u.serial, c.rule, c.issued, e.time, e.who, c.format FROM certificates c "
      "JOIN results "
      "r "
      "ON r.id = c.result JOIN units u ON u.id = r.unit LEFT JOIN events e ON e.subject = c.sha256 AND e.action = "
      "'certificate' WHERE c.number = ? ORDER BY e.time, c.sha256",
      {certificate.number}, [&](const Row& row) {
        const auto cell = [&](std::size_t column) { return database::text(row, column); };
        const bool same_result = cell(1) == certificate.result;
        const bool same = same_result && cell(4) == certificate.rule && cell(5) == certificate.issued &&
                          cell(8) != form_of(certificate);
        if (!problem.empty() || cell(0) == sha256 || same) return;
        const Sentence other = same_result ? say("another certificate on this result (issued on {}, rule {}, {})",
                                                 Name{cell(5).empty() ? "-" : cell(5)},
                                                 Name{cell(4).empty() ? "-" : cell(4)}, Name{cell(8)})
                                           : say("a certificate of {}/{} on the result {}", Name{cell(2)},
                                                 Name{cell(3)}, Name{first_digits(cell(1))});
        problem =
            say("certificate number '{}' belongs to {} since {} ({}): give this one a number of its own, "
                "certificate.number. "
                "An amended certificate has its own number too, and names the old one in certificate.replaces",
                certificate.number, other, cell(6).empty() ? Sentence("an unknown time") : say("{}", Name{cell(6)}),
                Name{cell(7)});
      });
  return problem;
}

bool put_certificate(Change& change, const CertificateDeposit& certificate, const std::string& sha256) {
  for (const auto& one : certificate.equipment) put_equipment(change, one);
  if (is_there(change, "certificates", "sha256", sha256)) return false;
  const auto units =
      change.database().ask("SELECT u.model, u.serial FROM results r JOIN units u ON u.id = r.unit WHERE r.id = ?",
                            {schema::number_of(certificate.result)});
  const auto chain = schema::chain_of_unit(database::text(units.at(0), 0), database::text(units.at(0), 1));
  // The number is the key of its table: a second writer waits here for the first, and sees its certificate below.
  if (!is_there(change, "certificate_numbers", "number", certificate.number))
    change.append(
        chain, {"certificate number", certificate.number, {}, sha256},
        {{&schema::certificate_numbers, {{certificate.number, schema::number_of(certificate.result), sha256}}}});
  if (const auto problem = problem_of_number(change.database(), certificate, sha256); !problem.empty())
    throw Error(Error::Kind::bad_input, problem);
  change.append(chain, {"certificate", sha256, {}, certificate.number},
                {{&schema::certificates,
                  {{sha256, certificate.number, schema::number_of(certificate.result), form_of(certificate),
                    text_or_nothing(certificate.rule), text_or_nothing(certificate.issued_by),
                    text_or_nothing(certificate.issued)}}}});
  return true;
}

}  // namespace tumble::deposits
