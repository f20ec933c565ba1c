#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/archive/deposit.hpp"
#include "tumble/archive/schema/chain.hpp"
#include "tumble/core/estimate.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::deposits {

/// A result as it is put in.
struct ReadResult {
  const ResultDeposit* deposit = nullptr;
  std::string sha256, program_version;
  Estimate estimate;
  UnitName unit;
  std::string begun, ended;
  std::optional<std::int64_t> corrects;  ///< number of the result that it replaces
};

struct ReadInput {
  std::string role, sha256, name;
};

/// Files that a result was made from: plans, recordings, the calibration.
std::vector<ReadInput> inputs_of(const Estimate& estimate);

/// Problems of a model and serial number, whose indexes have limits.
Problems problems_of_name(const UnitName& unit);

/// Reads it. Adds to `problems` what is wrong.
ReadResult read_result(const ResultDeposit& deposit, Problems& problems);

/// Number of a unit; its row and its first event are appended where it is new.
std::int64_t unit_row(schema::Change& change, const UnitName& unit);
/// Each returns whether it was new.
bool put_result(schema::Change& change, const ReadResult& result);
bool put_file(schema::Change& change, const FileDeposit& file, const std::string& sha256, std::int64_t bytes);
bool put_equipment(schema::Change& change, const EquipmentDeposit& equipment);
bool put_run(schema::Change& change, const RunDeposit& run);
/// Why a certificate may not have its number; empty: it may. A number belongs to the certificates of one result by one
/// rule and of one day: its forms and languages.
std::string problem_of_number(database::Database& database, const CertificateDeposit& certificate,
                              const std::string& sha256);
/// Throws Error::bad_input where the number belongs to another certificate.
bool put_certificate(schema::Change& change, const CertificateDeposit& certificate, const std::string& sha256);

std::string equipment_id(const EquipmentDeposit& equipment);
std::string sha256_of_unit(const UnitName& unit);

}  // namespace tumble::deposits
