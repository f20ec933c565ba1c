#include "tumble/archive/verify.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "tumble/archive/schema/chain.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/storage/packing.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

namespace {

using database::Row;
using database::text;

class Verification {
 public:
  Verification(const Archive& archive, ArchiveCheck& check)
      : database_(schema::opened(archive).database), files_(schema::opened(archive).files()), check_(check) {}

  void chain(const std::string& name) {
    std::int64_t expected = 1;
    std::string previous;
    for (const Row& row : database_.ask(schema::select_all(schema::events) + " WHERE chain = ? ORDER BY seq", {name})) {
      ++check_.events;
      const std::string where = name + ", event " + std::to_string(database::integer(row, 1));
      if (database::integer(row, 1) != expected) complain(say("{}: an event before it is missing", Name{where}));
      if (text(row, 9) != previous) complain(say("{}: does not follow the event before it", Name{where}));
      if (schema::sha256_of_event(row) != text(row, 10)) complain(say("{}: the event has changed", Name{where}));
      expected = database::integer(row, 1) + 1;
      previous = text(row, 10);
      rows_of(row, where);
    }
    heads_ += name + " " + previous + "\n";
    ++check_.chains;
  }

  /// After all chains: rows that no event brought.
  void counts() {
    for (const auto* shape : schema::covered_shapes()) {
      database_.run(schema::select_all(*shape) + " LIMIT 0");  // refused where a column is not there, also without rows
      const auto there = database_.ask("SELECT COUNT(*) FROM " + shape->name);
      const auto covered = covered_[shape];
      if (const auto count = database::integer(there.at(0), 0); count != covered)
        complain(say("table {}: has {} rows, and events brought {}", Name{shape->name}, count, covered));
    }
    check_.heads = sha256_of(heads_);
  }

  void complain(const Sentence& problem) { check_.problems.emplace_back(problem); }

 private:
  void rows_of(const Row& event, const std::string& where) {
    const std::string &action = text(event, 4), &subject = text(event, 5);
    const auto& shapes = schema::shapes_of(action);
    if (shapes.empty()) return;
    schema::RowDigest digest;
    for (const auto* shape : shapes)
      database_.visit(schema::select_all(*shape) + " WHERE " + shape->key + " = ?", {schema::key_of(*shape, subject)},
                      [&](const Row& row) {
                        digest.add(*shape, row);
                        ++covered_[shape];
                        contents_of(*shape, row);
                      });
    if (digest.hex() != text(event, 8))
      complain(say("{}: the {} {} has changed", Name{where}, Name{action}, Name{subject}));
  }

  void contents_of(const schema::Shape& shape, const Row& row) try {
    if (&shape == &schema::results) {
      ++check_.results;
      const Sentence what = say("result {}", Name{first_digits(text(row, 1))});
      if (sha256_of(storage::unpacked(database::bytes(row, shape.columns.size() - 1), what)) != text(row, 1))
        complain(say("{}: its bytes have changed since it was archived", what));
    } else if (&shape == &schema::files || &shape == &schema::certificates) {
      ++check_.files;
      storage::unpack(files_, text(row, 0), [](std::string_view) {});
    }
  } catch (const Error& error) {
    complain(reason_of(error));
  }

  database::Database& database_;
  storage::Place files_;
  std::string heads_;
  ArchiveCheck& check_;
  std::map<const schema::Shape*, std::int64_t> covered_;
};

/// Numbers that stand on certificates of several results, with the units of these.
std::vector<Sentence> shared_numbers_of(database::Database& database) {
  std::vector<Sentence> all;
  std::map<std::string, std::set<std::string>> sharing;
  database.visit(
      "SELECT DISTINCT c.number, u.model, u.serial, r.sha256 FROM certificates c JOIN results r ON r.id = c.result "
      "JOIN "
      "units u ON u.id = r.unit WHERE c.number IN (SELECT number FROM certificates GROUP BY number HAVING "
      "COUNT(DISTINCT result) > 1)",
      {}, [&](const Row& row) {
        sharing[text(row, 0)].insert(
            fmt::format("{}/{} (result {})", text(row, 1), text(row, 2), first_digits(text(row, 3))));
      });
  for (const auto& [number, results] : sharing)
    all.push_back(say("certificate number '{}' stands on certificates of {} results: {}", number, results.size(),
                      fmt::join(results, ", ")));
  return all;
}

void verify_rows(const Archive& archive, ArchiveCheck& check, const Progress& progress) {
  auto& database = schema::opened(archive).database;
  check.problems = database.damage();
  if (!check.problems.empty()) return;
  Verification verification(archive, check);
  std::vector<std::string> chains;
  database.visit("SELECT DISTINCT chain FROM events", {}, [&](const Row& row) { chains.push_back(text(row, 0)); });
  std::ranges::sort(chains);
  for (std::size_t i = 0; i < chains.size(); ++i) {
    report(progress, static_cast<double>(i) / static_cast<double>(chains.size()), "verifying");
    verification.chain(chains[i]);
  }
  verification.counts();
  for (auto& problem : schema::problems_of_triggers(database)) check.problems.push_back(std::move(problem));
  for (auto& problem : schema::problems_of_versions(database)) check.problems.push_back(std::move(problem));
  check.shared_numbers = shared_numbers_of(database);
}

}  // namespace

/// A file that is damaged so much that SQLite refuses it is a problem that was found.
ArchiveCheck verify_archive(const Archive& archive, const Progress& progress) {
  ArchiveCheck check;
  try {
    verify_rows(archive, check, progress);
  } catch (const database::Refusal& refusal) {
    check.problems.push_back(Sentence(refusal.text.c_str()));
  }
  return check;
}

}  // namespace tumble
