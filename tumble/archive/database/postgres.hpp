#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>

#include "tumble/archive/database/value.hpp"

struct pg_conn;  // a connection of libpq

namespace tumble::database {

/// An archive on a PostgreSQL server. libpq is loaded with the first one. All functions throw Refusal.
class Postgres {
 public:
  /// `address`: "postgresql://user@host/database", as libpq takes it.
  explicit Postgres(const std::string& address);
  void rows(const std::string& sql, const Row& values, const RowSink& sink);
  void script(const std::string& sql);
  std::int64_t changed() const { return changed_; }  ///< rows that the last INSERT wrote

 private:
  struct Finish {
    void operator()(pg_conn* connection) const;
  };
  const std::string& prepared(const std::string& sql, const Row& values);

  std::unique_ptr<pg_conn, Finish> connection_;
  std::unordered_map<std::string, std::string> names_;  ///< of prepared statements, by their SQL
  std::int64_t changed_ = 0;
};

/// `?` outside of quotes becomes $1, $2, ...
std::string numbered_parameters(const std::string& sql);

}  // namespace tumble::database
