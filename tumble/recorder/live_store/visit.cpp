#include "tumble/recorder/live_store/visit.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "tumble/formats/confinement.hpp"
#include "tumble/recorder/live_store/order.hpp"
#include "tumble/recorder/live_store/store_file.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::live_store {

namespace fs = std::filesystem;

std::string path_of_store(const std::string& run) {
  const std::string path = fs::is_directory(run) ? (fs::path(run) / live_store_name).string() : run;
  require_contained(path);
  if (!fs::is_regular_file(path))
    throw Error(Error::Kind::bad_file, say("'{}' is not a run: a run is a folder with a live store, {}", run,
                                           Name{std::string(live_store_name)}));
  return path;
}

StoreFile open_store(const std::string& path, Disk& disk) {
  try {
    return StoreFile(path, disk.vfs(), Database::Mode::existing);
  } catch (const Refusal& refusal) {
    refuse_to_read(path, refusal);
  }
}

void refuse_to_read(const std::string& path, const Refusal& refusal) {
  if (refusal.busy())
    throw Error(Error::Kind::bad_file, say("'{}' is still being recorded by another process; end that first", path));
  throw Error(Error::Kind::bad_file, say("'{}' cannot be read as a live store: {}", path, system_reason(refusal.text)));
}

namespace {

/// Facts about one slot have its name behind theirs.
void take_fact(const std::string& name, const std::string& value, StoreContent& content) {
  if (const auto unit = key_and_value(name, ' '); unit && unit->first == unit_fact) content.units[unit->second] = value;
  if (name == sealed_fact) content.sealed[""] = value;
  if (const auto sealed = key_and_value(name, '.'); sealed && sealed->first == sealed_fact)
    content.sealed[sealed->second] = value;
}

void read_descriptions(const Database& database, StoreContent& content) {
  Statement links(database, "SELECT json FROM link ORDER BY id");
  while (links.next()) content.links.push_back(link_of(links.bytes(0)));
  Statement streams(database, "SELECT json FROM stream ORDER BY id");
  while (streams.next()) content.streams.push_back(stream_of(streams.bytes(0)));
  Statement facts(database, "SELECT name, value FROM fact ORDER BY name");
  while (facts.next()) {
    const std::string name(facts.bytes(0));
    content.facts[name] = facts.bytes(1);
    take_fact(name, content.facts[name], content);
  }
}

/// A row; false where its checksum does not hold.
bool read_chunk(const Statement& row, Chunk& chunk) {
  chunk.first = static_cast<std::uint64_t>(row.integer(0));
  chunk.last = static_cast<std::uint64_t>(row.integer(1));
  const std::int64_t kind = row.integer(3);
  chunk.source = static_cast<std::size_t>(row.integer(4));
  chunk.count = static_cast<std::uint64_t>(row.integer(5));
  chunk.begin = row.number(6);
  chunk.end = row.number(7);
  chunk.body = row.bytes(9);
  if (kind < 0 || kind > static_cast<std::int64_t>(StoreItem::Kind::journal)) return false;
  chunk.kind = static_cast<StoreItem::Kind>(kind);
  return static_cast<std::uint32_t>(row.integer(8)) == checksum_of(chunk.body);
}

void read_chunks(const Database& database, StoreContent& content, const std::function<void(const StoreItem&)>& visit,
                 bool events_alone) {
  Order order(content.streams);
  std::deque<Chunk> chunks;  // of one batch
  const auto end_batch = [&] {
    for (const Chunk& chunk : chunks) content.damaged += !order.add(chunk);
    order.hand_out([&](const StoreItem& item) {
      ++content.items;
      visit(item);
    });
    chunks.clear();
  };
  std::int64_t batch = -1;
  const std::string some =
      events_alone ? fmt::format(" WHERE kind >= {}", static_cast<int>(StoreItem::Kind::event)) : "";
  Statement rows(database, "SELECT first, last, batch, kind, source, count, begin, end, crc, body FROM chunk" + some +
                               " ORDER BY first");
  while (rows.next()) {
    if (rows.integer(2) != batch) end_batch();
    batch = rows.integer(2);
    if (!read_chunk(rows, chunks.emplace_back())) {
      chunks.pop_back();
      ++content.damaged;
    }
  }
  end_batch();
}

}  // namespace

StoreContent describe(const StoreFile& store) {
  StoreContent content;
  read_descriptions(store.database(), content);
  return content;
}

void visit(const StoreFile& store, StoreContent& content, const std::function<void(const StoreItem&)>& visitor,
           bool events_alone) {
  content.items = content.damaged = 0;
  read_chunks(store.database(), content, visitor, events_alone);
}

}  // namespace tumble::live_store
