#include "tumble/formats/ros/joined.hpp"

#include <utility>

namespace tumble::ros {
namespace {

/// Numbers of connections hold within one file: those of the joined log are (file, number).
using Numbers = std::vector<std::map<std::uint32_t, std::uint32_t>>;

/// The joined number of a connection that no header named.
constexpr std::uint32_t nowhere = 0xffffffff;

std::uint32_t joined_number(const std::map<std::uint32_t, std::uint32_t>& numbers, std::uint32_t own) {
  const auto found = numbers.find(own);
  return found == numbers.end() ? nowhere : found->second;
}

void visit(const Log& part, const std::map<std::uint32_t, std::uint32_t>& numbers, const Piece& piece, Window& window,
           const Visitor& outer) {
  std::uint32_t last = 0, number = joined_number(numbers, 0);
  const auto turn_to = [&](std::uint32_t own) {
    if (own != std::exchange(last, own)) number = joined_number(numbers, own);
    return number;
  };
  Visitor visitor;
  if (outer.wants) visitor.wants = [&](std::uint32_t own) { return outer.wants(turn_to(own)); };
  visitor.message = [&](const Message& message) {
    outer.message({turn_to(message.connection), message.time, message.bytes});
  };
  part.visit(part, piece, window, visitor);
}

}  // namespace

Log joined(const std::string& path, std::vector<Log> parts) {
  Log log;
  log.path = path;
  Numbers numbers(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    Log& part = parts[p];
    look_into_uncounted(part);
    for (const auto& [own, connection] : part.connections) {
      const auto number = static_cast<std::uint32_t>(log.connections.size());
      numbers[p].emplace(own, number);
      log.connections.emplace(number, connection);
    }
    for (const auto& [own, count] : part.counts) log.counts[joined_number(numbers[p], own)].add(count);
    for (Piece piece : part.pieces) {
      piece.part = p;
      log.pieces.push_back(std::move(piece));
    }
    log.messages_at_most += part.messages_at_most;
    log.findings.insert(log.findings.end(), part.findings.begin(), part.findings.end());
  }
  log.parts = std::move(parts);
  log.visit = [numbers](const Log& whole, const Piece& piece, Window& window, const Visitor& visitor) {
    visit(whole.parts[piece.part], numbers[piece.part], piece, window, visitor);
  };
  return log;
}

}  // namespace tumble::ros
