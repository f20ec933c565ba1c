#include "tumble/archive/transfer/copy.hpp"

#include <algorithm>

#include "tumble/formats/temporary_folder.hpp"
#include "tumble/units/error.hpp"

namespace tumble::transfer {

namespace {

using database::Row;
using database::text;

/// Columns of an event.
enum EventColumn : std::size_t {
  seq = 1,
  time = 2,
  who = 3,
  action = 4,
  subject = 5,
  reason = 6,
  detail = 7,
  hash = 10
};

std::vector<Row> events_of(database::Database& database, const std::string& chain) {
  return database.ask(schema::select_all(schema::events) + " WHERE chain = ? ORDER BY seq", {chain});
}

std::size_t common_length(const std::vector<Row>& a, const std::vector<Row>& b) {
  std::size_t length = 0;
  while (length < std::min(a.size(), b.size()) && text(a[length], hash) == text(b[length], hash)) ++length;
  return length;
}

/// All that an event says, without its place in the chain.
std::string content_of(const Row& event) {
  std::string all;
  for (const std::size_t column : {time, who, action, subject, reason, detail}) all += text(event, column) + '\0';
  return all;
}

std::vector<schema::Change::Rows> rows_of(database::Database& database, const Row& event) {
  std::vector<schema::Change::Rows> tables;
  for (const auto* shape : schema::shapes_of(text(event, action)))
    tables.push_back({shape, database.ask(schema::select_all(*shape) + " WHERE " + shape->key + " = ?",
                                          {schema::key_of(*shape, text(event, subject))})});
  return tables;
}

/// Whether the first table of an event, which always has a row, has one of this key already.
bool rows_are_there(database::Database& database, const Row& event) {
  const auto& shapes = schema::shapes_of(text(event, action));
  if (shapes.empty()) return false;
  const auto& shape = *shapes.front();
  return !database
              .ask("SELECT 1 FROM " + shape.name + " WHERE " + shape.key + " = ?",
                   {schema::key_of(shape, text(event, subject))})
              .empty();
}

/// The events of the source that the destination lacks, in order.
std::vector<Row> missing_events(const Way& way, const std::vector<Row>& source, const std::vector<Row>& destination,
                                Transferred& done) {
  std::set<std::string> known;
  for (const auto& event : destination) known.insert(content_of(event));
  std::vector<Row> missing;
  for (auto event = source.begin() + static_cast<std::ptrdiff_t>(common_length(source, destination));
       event != source.end(); ++event) {
    if (known.contains(content_of(*event)) || rows_are_there(way.to, *event))
      ++done.known;
    else
      missing.push_back(*event);
  }
  return missing;
}

/// An event with its rows, as it is: it follows the last one of the destination.
void copy_event(const Way& way, const Row& event) {
  for (const auto& [shape, rows] : rows_of(way.from, event)) schema::insert(way.to, *shape, rows);
  schema::insert(way.to, schema::events, {event});
}

}  // namespace

void copy_chain(const Way& way, const std::string& chain, Transferred& done) {
  const auto source = events_of(way.from, chain), destination = events_of(way.to, chain);
  const auto missing = missing_events(way, source, destination, done);
  if (missing.empty()) return;
  const std::size_t common = common_length(source, destination);
  if (common == destination.size() && missing.size() == source.size() - common) {
    for (const auto& event : missing) copy_event(way, event);
  } else {
    schema::Change change(way.to, way.who, way.when);
    change.append(chain, {"import", text(source.back(), hash), {}, way.origin});
    for (const auto& event : missing)
      change.append_at(chain, {text(event, action), text(event, subject), text(event, reason), text(event, detail)},
                       text(event, time), text(event, who), rows_of(way.from, event));
  }
  done.events += missing.size();
  done.results += static_cast<std::size_t>(
      std::ranges::count_if(missing, [](const Row& event) { return text(event, action) == "result"; }));
}

std::set<std::string> files_of_chain(database::Database& database, const std::string& chain) {
  std::set<std::string> files;
  database.visit("SELECT subject FROM events WHERE chain = ? AND (action = 'file' OR action = 'certificate')", {chain},
                 [&](const Row& row) { files.insert(text(row, 0)); });
  return files;
}

bool copy_file(const storage::Place& from, const storage::Place& to, const std::string& sha256) {
  if (storage::is_kept(to, sha256)) return false;
  const TemporaryFolder folder;
  const std::string copy = (folder.path() / "file").string();
  storage::unpack_to(from, sha256, copy);
  storage::keep(to, copy);
  return true;
}

}  // namespace tumble::transfer
