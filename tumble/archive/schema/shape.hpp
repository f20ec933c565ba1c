#pragma once

#include <string>
#include <vector>

#include "tumble/archive/database/database.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::schema {

/// A table of the archive: its name, its columns in order, and the key by which an event covers rows of it.
struct Shape {
  std::string name;
  std::vector<std::string> columns;
  std::string key;        ///< column that holds the subject of the event
  std::size_t added = 0;  ///< so many of the columns, the last ones, came with a later version
};

extern const Shape units, files, results, parameters, inputs, certificates, certificate_numbers, corrections, runs,
    run_units, run_equipment, equipment, calibrations, facts, events;

/// All tables whose rows events cover.
const std::vector<const Shape*>& covered_shapes();

/// Tables whose rows an event of this kind covers; empty: the event has no rows.
const std::vector<const Shape*>& shapes_of(const std::string& action);
/// The key of these rows for the subject of the event: of units and results the number that follows from a SHA-256.
database::Value key_of(const Shape& shape, const std::string& subject);

/// "SELECT a, b, c FROM table", all columns in order.
std::string select_all(const Shape& shape);
/// Rows in one statement. Throws database::Refusal, also where the database did not write all of them.
void insert(database::Database& database, const Shape& shape, const std::vector<database::Row>& rows);

/// Number of a row from a SHA-256: its first 60 bits.
std::int64_t number_of(const std::string& sha256);

/// The version of the schema that this program makes and reads.
std::int64_t newest_version();

/// Problems of the versions that the tables were made and brought up to date by, as the chain of the archive has them.
Problems problems_of_versions(database::Database& database);

/// Problems of the triggers that refuse changes of rows: missing, switched off, or others beside them.
Problems problems_of_triggers(database::Database& database);

/// Who brings a schema up to date, when (UTC), and with which version of the program.
struct Migration {
  std::string who, when, program;
};
/// Makes the tables of an empty database, or brings those of an earlier version up to date: one transaction, with an
/// event. Throws database::Refusal.
void migrate(database::Database& database, std::int64_t from, const Migration& migration);
/// 0 where the database has no archive.
std::int64_t version_of(database::Database& database);

}  // namespace tumble::schema
