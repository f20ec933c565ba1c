#include <fmt/format.h>

#include <cstdlib>
#include <iterator>
#include <map>
#include <set>

#include "tumble/archive/schema/chain.hpp"
#include "tumble/archive/schema/shape.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::schema {

namespace {

/// What both databases understand. BLOB is BYTEA on a server. Steps of earlier versions are never changed.
constexpr const char* step_1 = R"(
CREATE TABLE facts (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE units (id BIGINT PRIMARY KEY, model TEXT NOT NULL, serial TEXT NOT NULL, maker TEXT, revision TEXT,
  UNIQUE (serial, model));
CREATE TABLE files (sha256 TEXT PRIMARY KEY, unit BIGINT, run TEXT, slot TEXT, role TEXT NOT NULL, name TEXT NOT NULL,
  bytes BIGINT NOT NULL);
CREATE TABLE results (id BIGINT PRIMARY KEY, sha256 TEXT NOT NULL UNIQUE, unit BIGINT NOT NULL, run TEXT,
  method TEXT NOT NULL, title TEXT NOT NULL, plan_sha256 TEXT, station_sha256 TEXT, program_version TEXT NOT NULL,
  seed TEXT, verdict TEXT, begun TEXT, ended TEXT, archived TEXT NOT NULL, who TEXT NOT NULL, moment BIGINT NOT NULL,
  bytes BIGINT NOT NULL, packed BLOB NOT NULL);
CREATE TABLE parameters (result BIGINT NOT NULL, place BIGINT NOT NULL, name TEXT NOT NULL, symbol TEXT,
  value DOUBLE PRECISION, sd DOUBLE PRECISION, degrees_of_freedom DOUBLE PRECISION, shown_unit TEXT NOT NULL,
  unit BIGINT NOT NULL, moment BIGINT NOT NULL, PRIMARY KEY (result, place));
CREATE TABLE inputs (result BIGINT NOT NULL, place BIGINT NOT NULL, role TEXT NOT NULL, sha256 TEXT NOT NULL,
  name TEXT NOT NULL, PRIMARY KEY (result, place));
CREATE TABLE certificates (sha256 TEXT PRIMARY KEY, number TEXT NOT NULL, result BIGINT NOT NULL, format TEXT NOT NULL,
  rule TEXT, issued_by TEXT, issued TEXT);
CREATE TABLE corrections (result BIGINT PRIMARY KEY, replaced_by BIGINT, reason TEXT NOT NULL, who TEXT NOT NULL,
  corrected TEXT NOT NULL);
CREATE TABLE runs (id TEXT PRIMARY KEY, title TEXT NOT NULL, plan_sha256 TEXT, station TEXT, station_sha256 TEXT,
  program_version TEXT, operator TEXT, started TEXT, ended TEXT, ending TEXT);
CREATE TABLE run_units (run TEXT NOT NULL, slot TEXT NOT NULL, unit BIGINT NOT NULL, PRIMARY KEY (run, slot));
CREATE TABLE run_equipment (run TEXT NOT NULL, equipment TEXT NOT NULL, certificate TEXT,
  PRIMARY KEY (run, equipment));
CREATE TABLE equipment (id TEXT PRIMARY KEY, name TEXT NOT NULL, maker TEXT, model TEXT, serial TEXT, firmware TEXT,
  location TEXT);
CREATE TABLE calibrations (id TEXT PRIMARY KEY, equipment TEXT NOT NULL, certificate TEXT NOT NULL, laboratory TEXT,
  due TEXT, document_sha256 TEXT);
CREATE TABLE events (chain TEXT NOT NULL, seq BIGINT NOT NULL, time TEXT NOT NULL, who TEXT NOT NULL,
  action TEXT NOT NULL, subject TEXT NOT NULL, reason TEXT, detail TEXT, rows_sha256 TEXT, previous TEXT,
  sha256 TEXT NOT NULL, PRIMARY KEY (chain, seq));
CREATE INDEX results_of_unit ON results (unit, moment);
CREATE INDEX results_of_run ON results (run);
CREATE INDEX parameters_over_units ON parameters (name, moment, unit, value, sd, result);
CREATE INDEX inputs_by_hash ON inputs (sha256);
CREATE INDEX files_of_unit ON files (unit);
CREATE INDEX certificates_of_result ON certificates (result);
CREATE INDEX calibrations_of_equipment ON calibrations (equipment);
CREATE INDEX runs_of_unit ON run_units (unit);
)";

constexpr const char* tables_of_step_1[] = {"facts",         "units",        "files",        "results", "parameters",
                                            "inputs",        "certificates", "corrections",  "runs",    "run_units",
                                            "run_equipment", "equipment",    "calibrations", "events"};

/// What charts need of a result without reading it: the part of an uncertainty that no other result shares, and which
/// errors are shared (deposits/sources.hpp). Files may lie within the database.
constexpr const char* step_2 = R"(
ALTER TABLE parameters ADD COLUMN private_sd DOUBLE PRECISION;
ALTER TABLE parameters ADD COLUMN sources BIGINT;
ALTER TABLE parameters ADD COLUMN verdict TEXT;
ALTER TABLE calibrations ADD COLUMN calibrated TEXT;
CREATE TABLE contents (sha256 TEXT NOT NULL, part BIGINT NOT NULL, packed BLOB NOT NULL, PRIMARY KEY (sha256, part));
DROP INDEX parameters_over_units;
CREATE INDEX parameters_over_units ON parameters (name, moment, unit, value, sd, result, private_sd, sources);
)";

/// A number belongs to the certificates of one result. Those that were archived before stay as they are, also where
/// several results share one.
constexpr const char* step_3 = R"(
CREATE TABLE certificate_numbers (number TEXT PRIMARY KEY, result BIGINT NOT NULL, sha256 TEXT NOT NULL);
CREATE INDEX certificates_by_number ON certificates (number);
)";

constexpr const char* tables_of_later_steps[] = {"contents", "certificate_numbers"};

std::string for_engine(std::string sql, bool server) {
  const std::string from = " BLOB", to = " BYTEA";
  for (auto at = sql.find(from); server && at != std::string::npos; at = sql.find(from, at + to.size()))
    sql.replace(at, from.size(), to);
  return sql;
}

/// Triggers that refuse to change and to delete rows.
std::string append_only(const std::string& table, bool server) {
  const std::string text = "the archive is append-only: a correction is a new row";
  if (server)
    return fmt::format(
        "CREATE TRIGGER {0}_stays BEFORE UPDATE OR DELETE OR TRUNCATE ON {0} EXECUTE FUNCTION tumble_refuse();\n",
        table);
  std::string sql;
  for (const char* const change : {"UPDATE", "DELETE"})
    sql += fmt::format("CREATE TRIGGER {0}_no_{1} BEFORE {1} ON {0} BEGIN SELECT RAISE(ABORT, '{2}'); END;\n", table,
                       change, text);
  return sql;
}

constexpr const char* refuse_on_server =
    "CREATE FUNCTION tumble_refuse() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN RAISE EXCEPTION "
    "'the archive is append-only: a correction is a new row'; END $$;\n";

std::string first_schema(bool server) {
  std::string sql = for_engine(step_1, server);
  if (server) sql += refuse_on_server;
  for (const char* const table : tables_of_step_1) sql += append_only(table, server);
  return sql;
}

/// Names and texts of the triggers of a database; of a server the names of those that are enabled.
std::set<std::string> triggers_of(database::Database& database) {
  std::set<std::string> found;
  const auto rows =
      database.server()
          ? database.ask(
                "SELECT t.tgname::text FROM pg_trigger t JOIN pg_class c ON c.oid = t.tgrelid WHERE NOT "
                "t.tgisinternal AND t.tgenabled <> 'D' AND c.relnamespace = ANY (SELECT oid FROM pg_namespace "
                "WHERE nspname = ANY (current_schemas(false)))")
          : database.ask("SELECT sql FROM sqlite_master WHERE type = 'trigger'");
  for (const auto& row : rows) found.insert(database::text(row, 0));
  return found;
}

void note_version(database::Database& database, std::int64_t version, const Migration& migration) {
  database.run("INSERT INTO schema_version (version, applied, program) VALUES (?, ?, ?)",
               {version, migration.when, migration.program});
}

/// Facts had no event before.
void second_schema(database::Database& database, const Migration& migration) {
  const bool server = database.server();
  database.script(for_engine(step_2, server) + append_only("contents", server));
  Change change(database, migration.who, migration.when);
  for (const auto& row : database.ask(select_all(facts) + " ORDER BY name"))
    change.cover(chain_of_archive, {"fact", database::text(row, 0), {}, {}}, {{&facts, {row}}});
  change.append(chain_of_archive, {"schema", "2", {}, "Tumble " + migration.program});
}

void third_schema(database::Database& database, const Migration& migration) {
  database.script(for_engine(step_3, database.server()) + append_only("certificate_numbers", database.server()));
  Change change(database, migration.who, migration.when);
  change.append(chain_of_archive, {"schema", "3", {}, "Tumble " + migration.program});
}

}  // namespace

/// Version 1 has no event: its note must be there, and those of later versions as their events say.
Problems problems_of_versions(database::Database& database) {
  std::map<std::int64_t, std::string> noted;
  Problems problems;
  for (const auto& row : database.ask("SELECT version, applied, program FROM schema_version ORDER BY version"))
    noted[database::integer(row, 0)] = database::text(row, 1) + ", Tumble " + database::text(row, 2);
  std::map<std::int64_t, std::string> happened;
  for (const auto& row :
       database.ask("SELECT subject, time, detail FROM events WHERE chain = ? AND action = 'schema' ORDER BY seq",
                    {std::string(chain_of_archive)}))
    happened[std::atoll(database::text(row, 0).c_str())] = database::text(row, 1) + ", " + database::text(row, 2);
  for (std::int64_t version = 1; version <= newest_version(); ++version) {
    const auto note = noted.find(version);
    if (note == noted.end())
      problems.push_back(say("table schema_version: the note of version {} is missing", version));
    else if (version > 1 && note->second != happened[version])
      problems.push_back(say("table schema_version: version {} is noted as of {}, and its event says {}", version,
                             Name{note->second},
                             happened[version].empty() ? Sentence("nothing") : say("{}", Name{happened[version]})));
    noted.erase(version);
  }
  for (const auto& [version, note] : noted)
    problems.push_back(say("table schema_version: version {} is no version of an archive", version));
  return problems;
}

Problems problems_of_triggers(database::Database& database) {
  const bool server = database.server();
  std::vector<std::string> tables(std::begin(tables_of_step_1), std::end(tables_of_step_1));
  Problems problems;
  tables.insert(tables.end(), std::begin(tables_of_later_steps), std::end(tables_of_later_steps));
  auto found = triggers_of(database);
  for (const auto& table : tables) {
    std::string text = append_only(table, server);
    bool there = !server || found.erase(table + "_stays") == 1;
    for (auto end = text.find(";\n"); !server && end != std::string::npos; end = text.find(";\n")) {
      there = found.erase(text.substr(0, end)) == 1 && there;
      text.erase(0, end + 2);
    }
    if (!there) problems.push_back(say("table {}: the trigger that refuses changes is missing", Name{table}));
  }
  for (const auto& other : found)
    problems.push_back(say("a trigger that is no part of an archive: {}", Name{other.substr(0, 80)}));
  return problems;
}

std::int64_t newest_version() { return 3; }

/// Another program may have done it since `from` was read: the version is read again within the transaction.
void migrate(database::Database& database, std::int64_t from, const Migration& migration) {
  if (from >= newest_version()) return;
  database.transact([&] {
    if (from > 0 && database.server()) database.script("LOCK TABLE schema_version IN EXCLUSIVE MODE");
    const auto version = version_of(database);
    if (version < 1) {
      database.script(
          "CREATE TABLE schema_version (version BIGINT PRIMARY KEY, applied TEXT NOT NULL, program TEXT NOT NULL)");
      database.script(first_schema(database.server()));
      note_version(database, 1, migration);
    }
    if (version < 2) {
      second_schema(database, migration);
      note_version(database, 2, migration);
    }
    if (version < 3) {
      third_schema(database, migration);
      note_version(database, 3, migration);
    }
  });
}

std::int64_t version_of(database::Database& database) {
  const auto tables =
      database.server()
          ? database.ask(
                "SELECT table_name::text FROM information_schema.tables WHERE table_name = 'schema_version' "
                "AND table_schema = ANY (current_schemas(false))")
          : database.ask("SELECT name FROM sqlite_master WHERE type = 'table' AND name = 'schema_version'");
  if (tables.empty()) return 0;
  const auto versions = database.ask("SELECT MAX(version) FROM schema_version");
  return database::integer(versions.at(0), 0);
}

}  // namespace tumble::schema
