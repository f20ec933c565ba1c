#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "tumble/archive/database/postgres.hpp"
#include "tumble/archive/database/sqlite.hpp"
#include "tumble/archive/database/value.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::database {

/// Whether an address names a PostgreSQL server; else it is a file.
bool is_server(const std::string& address);

/// A database: an SQLite file or a PostgreSQL server, which understand the same SQL with parameters `?`. All functions
/// throw Refusal.
class Database {
 public:
  /// `create`: where the address is a file that is not there, an empty one is made.
  Database(const std::string& address, bool create);
  bool server() const { return std::holds_alternative<Postgres>(engine_); }

  /// Runs a statement, and hands out its rows.
  void visit(const std::string& sql, const Row& values, const RowSink& sink);
  std::vector<Row> ask(const std::string& sql, const Row& values = {});
  void run(const std::string& sql, const Row& values = {}) { visit(sql, values, {}); }
  /// Rows that the INSERT of the last run() wrote: a trigger or a rule may have swallowed some.
  std::int64_t changed() const;
  /// Statements without parameters, with `;` between them.
  void script(const std::string& sql);

  /// Does `work` in one transaction: all of it or nothing. Work that another writer came before is done again.
  void transact(const std::function<void()>& work);
  /// Problems of the file of the database itself; empty on a server.
  Problems damage();

 private:
  std::variant<Sqlite, Postgres> engine_;
};

}  // namespace tumble::database
