#include "tumble/archive/schema/shape.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <map>

namespace tumble::schema {

const Shape units{"units", {"id", "model", "serial", "maker", "revision"}, "id"};
const Shape files{"files", {"sha256", "unit", "run", "slot", "role", "name", "bytes"}, "sha256"};
const Shape results{
    "results",
    {"id", "sha256", "unit", "run", "method", "title", "plan_sha256", "station_sha256", "program_version", "seed",
     "verdict", "begun", "ended", "archived", "who", "moment", "bytes", "packed"},
    "id"};
const Shape parameters{"parameters",
                       {"result", "place", "name", "symbol", "value", "sd", "degrees_of_freedom", "shown_unit", "unit",
                        "moment", "private_sd", "sources", "verdict"},
                       "result",
                       3};
const Shape inputs{"inputs", {"result", "place", "role", "sha256", "name"}, "result"};
const Shape certificates{
    "certificates", {"sha256", "number", "result", "format", "rule", "issued_by", "issued"}, "sha256"};
/// To which result a number belongs, and the first certificate that had it. Numbers from before have no row.
const Shape certificate_numbers{"certificate_numbers", {"number", "result", "sha256"}, "number"};
const Shape corrections{"corrections", {"result", "replaced_by", "reason", "who", "corrected"}, "result"};
const Shape runs{"runs",
                 {"id", "title", "plan_sha256", "station", "station_sha256", "program_version", "operator", "started",
                  "ended", "ending"},
                 "id"};
const Shape run_units{"run_units", {"run", "slot", "unit"}, "run"};
const Shape run_equipment{"run_equipment", {"run", "equipment", "certificate"}, "run"};
const Shape equipment{"equipment", {"id", "name", "maker", "model", "serial", "firmware", "location"}, "id"};
const Shape calibrations{
    "calibrations", {"id", "equipment", "certificate", "laboratory", "due", "document_sha256", "calibrated"}, "id", 1};
const Shape facts{"facts", {"name", "value"}, "name"};
const Shape events{
    "events",
    {"chain", "seq", "time", "who", "action", "subject", "reason", "detail", "rows_sha256", "previous", "sha256"},
    "chain"};

const std::vector<const Shape*>& covered_shapes() {
  static const std::vector<const Shape*> all{
      &units, &files,     &results,       &parameters, &inputs,       &certificates, &corrections,
      &runs,  &run_units, &run_equipment, &equipment,  &calibrations, &facts,        &certificate_numbers};
  return all;
}

const std::vector<const Shape*>& shapes_of(const std::string& action) {
  static const std::vector<const Shape*> none;
  static const std::map<std::string, std::vector<const Shape*>> all{
      {"unit", {&units}},
      {"file", {&files}},
      {"result", {&results, &parameters, &inputs}},
      {"certificate", {&certificates}},
      {"certificate number", {&certificate_numbers}},
      {"correction", {&corrections}},
      {"run", {&runs, &run_units, &run_equipment}},
      {"equipment", {&equipment}},
      {"calibration", {&calibrations}},
      {"fact", {&facts}},
  };
  const auto known = all.find(action);
  return known == all.end() ? none : known->second;
}

database::Value key_of(const Shape& shape, const std::string& subject) {
  const bool number = shape.key == "result" || (shape.key == "id" && (&shape == &units || &shape == &results));
  return number ? database::Value(number_of(subject)) : database::Value(subject);
}

std::string select_all(const Shape& shape) {
  return fmt::format("SELECT {} FROM {}", fmt::join(shape.columns, ", "), shape.name);
}

void insert(database::Database& database, const Shape& shape, const std::vector<database::Row>& rows) {
  constexpr std::size_t most = 50;  // rows in a statement: SQLite and PostgreSQL limit the number of parameters
  std::string marks;
  for (std::size_t i = 0; i < shape.columns.size(); ++i) marks += i == 0 ? "(?" : ", ?";
  marks += ")";
  for (std::size_t begin = 0; begin < rows.size(); begin += most) {
    const std::size_t end = std::min(rows.size(), begin + most);
    const std::vector<std::string> all(end - begin, marks);
    database::Row values;
    for (std::size_t i = begin; i < end; ++i) values.insert(values.end(), rows[i].begin(), rows[i].end());
    database.run(
        fmt::format("INSERT INTO {} ({}) VALUES {}", shape.name, fmt::join(shape.columns, ", "), fmt::join(all, ", ")),
        values);
    if (const auto written = database.changed(); written != static_cast<std::int64_t>(end - begin))
      throw database::Refusal{
          database::Refusal::Kind::failed,
          fmt::format("the database wrote {} of {} rows of the table {}: a trigger or a rule that is no part of an "
                      "archive keeps the others out (`tumble archive verify` lists it)",
                      written, end - begin, shape.name)};
  }
}

std::int64_t number_of(const std::string& sha256) {
  std::int64_t number = 0;
  std::from_chars(sha256.data(), sha256.data() + std::min<std::size_t>(15, sha256.size()), number, 16);
  return number;
}

}  // namespace tumble::schema
