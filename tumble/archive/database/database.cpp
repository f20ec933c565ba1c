#include "tumble/archive/database/database.hpp"

#include "tumble/units/sentence.hpp"

namespace tumble::database {

namespace {

/// So often another writer may come first. Of 20 writers to one unit one always succeeds.
constexpr int attempts = 200;

std::variant<Sqlite, Postgres> engine_at(const std::string& address, bool create) {
  if (is_server(address)) return Postgres(address);
  return Sqlite(address, create);
}

/// A connection that is lost, or a commit that failed, has rolled back already.
void roll_back(Database& database) {
  try {
    database.script("ROLLBACK");
  } catch (const Refusal&) {
    return;
  }
}

}  // namespace

bool is_server(const std::string& address) {
  return address.starts_with("postgresql://") || address.starts_with("postgres://");
}

Database::Database(const std::string& address, bool create) : engine_(engine_at(address, create)) {}

void Database::visit(const std::string& sql, const Row& values, const RowSink& sink) {
  std::visit([&](auto& engine) { engine.rows(sql, values, sink); }, engine_);
}

std::vector<Row> Database::ask(const std::string& sql, const Row& values) {
  std::vector<Row> rows;
  visit(sql, values, [&](const Row& row) { rows.push_back(row); });
  return rows;
}

std::int64_t Database::changed() const {
  return std::visit([](const auto& engine) { return engine.changed(); }, engine_);
}

void Database::script(const std::string& sql) {
  std::visit([&](auto& engine) { engine.script(sql); }, engine_);
}

void Database::transact(const std::function<void()>& work) {
  for (int attempt = 1;; ++attempt) {
    script(server() ? "BEGIN" : "BEGIN IMMEDIATE");
    try {
      work();
      script("COMMIT");
      return;
    } catch (const Refusal& refusal) {
      roll_back(*this);
      if (refusal.kind != Refusal::Kind::conflict || attempt == attempts) throw;
    } catch (...) {
      roll_back(*this);
      throw;
    }
  }
}

Problems Database::damage() {
  Sqlite* const file = std::get_if<Sqlite>(&engine_);
  return file ? file->damage() : Problems{};
}

}  // namespace tumble::database
