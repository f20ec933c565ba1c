#pragma once

#include <optional>
#include <string>

namespace tumble::testing {

/// A PostgreSQL server of the distribution in a temporary folder, with a Unix socket and no network. Run by root, it
/// belongs to the user nobody, because a server refuses root. Stopped and removed at the end.
class PostgresServer {
 public:
  PostgresServer();
  ~PostgresServer();
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  /// Address of a new, empty database of that name.
  std::string new_database(const std::string& name);
  std::string address(const std::string& database) const;

  /// Whether initdb and postgres are installed.
  static bool installed();

 private:
  std::string folder_;
};

}  // namespace tumble::testing
