#include "tumble/formats/ros/log.hpp"

#include <algorithm>
#include <filesystem>

#include "tumble/formats/checksum.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/units/error.hpp"

namespace tumble::ros {
namespace {

/// What a piece holds, as far as it can be read.
struct Content {
  std::map<std::uint32_t, Connection> connections;
  std::map<std::uint32_t, std::string> types;
  std::map<std::uint32_t, Count> counts;
};

/// What is damaged is reported where the piece is read.
void look_into(const Log& log, const Piece& piece, Content& content) {
  Window window;
  Visitor visitor;
  visitor.message = [&](const Message& message) { content.counts[message.connection].add(message.time); };
  visitor.connection = [&](std::uint32_t id, const Connection& found) { content.connections.emplace(id, found); };
  visitor.type = [&](std::uint32_t id, const std::string& name) { content.types.emplace(id, name); };
  try {
    log.visit(log, piece, window, visitor);
  } catch (const Error&) {
  } catch (const Untrusted&) {
  }
}

void learn(Content& content, Log& log) {
  log.connections.merge(content.connections);
  log.types.merge(content.types);
}

void count_pieces(Log& log, const std::vector<std::size_t>& which) {
  std::vector<Content> contents(which.size());
  parallel_for(which.size(), [&](std::size_t i) { look_into(log, log.pieces[which[i]], contents[i]); });
  for (std::size_t i = 0; i < which.size(); ++i) {
    log.pieces[which[i]].counted = true;
    learn(contents[i], log);
    for (const auto& [id, count] : contents[i].counts) log.counts[id].add(count);
  }
}

bool lacks_connections(const Log& log) {
  return std::ranges::any_of(log.counts, [&](const auto& entry) { return !log.connections.contains(entry.first); });
}

}  // namespace

void Count::add(std::int64_t time) {
  ++messages;
  first = std::min(first, time);
  last = std::max(last, time);
}

void Count::add(const Count& other) {
  messages += other.messages;
  first = std::min(first, other.first);
  last = std::max(last, other.last);
}

double Count::rate() const {
  if (messages < 2 || last <= first) return 0.0;
  return static_cast<double>(messages - 1) / (1e-9 * (static_cast<double>(last) - static_cast<double>(first)));
}

std::uint64_t size_of(const Log& log) {
  if (log.parts.empty()) return log.file->size();
  std::uint64_t bytes = 0;
  for (const Log& part : log.parts) bytes += part.file->size();
  return bytes;
}

std::function<std::string()> checksum_of(const Log& log) {
  if (log.parts.empty()) return sha256_in_background(log.path);
  std::vector<std::pair<std::string, std::function<std::string()>>> sums;
  for (const Log& part : log.parts)
    sums.emplace_back(std::filesystem::path(part.path).filename().string(), sha256_in_background(part.path));
  return [sums] {
    std::string list;
    for (const auto& [name, sum] : sums) list += sum() + "  " + name + "\n";
    return sha256_of(list);
  };
}

void look_into_uncounted(Log& log) {
  std::vector<std::size_t> uncounted;
  for (std::size_t i = 0; i < log.pieces.size(); ++i)
    if (!log.pieces[i].counted) uncounted.push_back(i);
  count_pieces(log, uncounted);
  for (std::size_t i = 0; i < log.pieces.size() && lacks_connections(log); ++i) {
    Content content;
    look_into(log, log.pieces[i], content);
    learn(content, log);
  }
  for (auto& [id, connection] : log.connections)
    if (const auto type = log.types.find(connection.type_id); connection.type.empty() && type != log.types.end())
      connection.type = type->second;
}

void count_messages(Log& log) {
  if (log.messages_at_most == 0) return;
  log.messages_at_most = 0;
  std::vector<std::size_t> all(log.pieces.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  count_pieces(log, all);
}

}  // namespace tumble::ros
