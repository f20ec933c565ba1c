#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/archive/schema/shape.hpp"

namespace tumble::schema {

/// SHA-256 over rows of tables, in any order. Every cell has its type and its length, so that no two different sets of
/// rows have the same text. Empty cells of columns that a later version added are not part of it, so that rows from
/// before have the text that they had.
class RowDigest {
 public:
  void add(const Shape& shape, const database::Row& row);
  std::size_t rows() const { return texts_.size(); }
  std::string hex() const;

 private:
  std::vector<std::string> texts_;
};

/// An event: the action, by whom and why.
struct Event {
  std::string action, subject, reason, detail;
};

/// The chain of a unit, of a run, of an instrument of the laboratory. A slash of a model is written %2F, so that no two
/// units share a chain.
std::string chain_of_unit(const std::string& model, const std::string& serial);
std::string chain_of_run(const std::string& run);
std::string chain_of_equipment(const std::string& id);
std::string chain_of_model(const std::string& model);
/// Chain of the archive itself: who made it, and who brought it up to date.
inline constexpr const char* chain_of_archive = "archive";

/// SHA-256 of an event, from its row: of all columns but the last.
std::string sha256_of_event(const database::Row& row);

/// One change of the archive within a transaction: rows are inserted, and events over them appended to chains.
class Change {
 public:
  Change(database::Database& database, std::string who, std::string when)
      : database_(database), who_(std::move(who)), when_(std::move(when)) {}

  struct Rows {
    const Shape* shape;
    std::vector<database::Row> rows;
  };
  /// Throws database::Refusal: a conflict where another writer appended to the chain.
  void append(const std::string& chain, const Event& event, const std::vector<Rows>& tables = {});
  /// Appends an event as append() does, over rows that are there already.
  void cover(const std::string& chain, const Event& event, const std::vector<Rows>& tables);
  /// With a time and a person of its own: what happened before it was archived.
  void append_at(const std::string& chain, const Event& event, const std::string& when, const std::string& who,
                 const std::vector<Rows>& tables = {});
  database::Database& database() const { return database_; }
  const std::string& who() const { return who_; }
  const std::string& when() const { return when_; }

 private:
  struct Head {
    std::int64_t seq = 0;
    std::string sha256;
  };
  static std::string digest_of(const std::vector<Rows>& tables);
  Head& head_of(const std::string& chain);
  void write(const std::string& chain, const Event& event, const std::string& when, const std::string& who,
             const std::string& rows_sha256);

  database::Database& database_;
  std::string who_, when_;
  std::map<std::string, Head> heads_;
};

}  // namespace tumble::schema
