#include "tumble/archive/schema/chain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

#include "tumble/archive/storage/packing.hpp"
#include "tumble/formats/checksum.hpp"

namespace tumble::schema {

namespace {

using database::Value;

std::string written(const Value& value) {
  return std::visit(
      [](const auto& cell) {
        using Cell = std::decay_t<decltype(cell)>;
        if constexpr (std::is_same_v<Cell, std::monostate>)
          return std::string("-;");
        else if constexpr (std::is_same_v<Cell, std::int64_t>)
          return fmt::format("i{};", cell);
        else if constexpr (std::is_same_v<Cell, double>)
          return fmt::format("d{};", cell);
        else if constexpr (std::is_same_v<Cell, std::string>)
          return fmt::format("t{}:{};", cell.size(), cell);
        else
          return fmt::format("b{};", storage::seal_of(cell.data));
      },
      value);
}

}  // namespace

/// Bytes are compressed results, of which the seal at their end is part of the digest.
void RowDigest::add(const Shape& shape, const database::Row& row) {
  std::string text = shape.name + "(";
  const std::size_t first = shape.columns.size() - shape.added;
  for (std::size_t i = 0; i < row.size(); ++i)
    if (i < first || !std::holds_alternative<std::monostate>(row[i]))
      text += i < first ? written(row[i]) : shape.columns[i] + "=" + written(row[i]);
  texts_.push_back(text + ")");
}

std::string RowDigest::hex() const {
  auto sorted = texts_;
  std::ranges::sort(sorted);
  std::string all;
  for (const auto& text : sorted) all += text;
  return sha256_of(all);
}

std::string chain_of_unit(const std::string& model, const std::string& serial) {
  std::string escaped;
  for (const char character : model)
    escaped += character == '/' ? "%2F" : character == '%' ? "%25" : std::string(1, character);
  return "unit/" + escaped + "/" + serial;
}
std::string chain_of_run(const std::string& run) { return "run/" + run; }
std::string chain_of_equipment(const std::string& id) { return "equipment/" + id; }
std::string chain_of_model(const std::string& model) { return "model/" + model; }

std::string sha256_of_event(const database::Row& row) {
  std::string text = "event(";
  for (std::size_t i = 0; i + 1 < row.size(); ++i) text += written(row[i]);
  return sha256_of(text + ")");
}

std::string Change::digest_of(const std::vector<Rows>& tables) {
  RowDigest digest;
  for (const auto& [shape, rows] : tables)
    for (const auto& row : rows) digest.add(*shape, row);
  return tables.empty() ? std::string() : digest.hex();
}

Change::Head& Change::head_of(const std::string& chain) {
  const auto known = heads_.find(chain);
  if (known != heads_.end()) return known->second;
  Head head;
  for (const auto& row :
       database_.ask("SELECT seq, sha256 FROM events WHERE chain = ? ORDER BY seq DESC LIMIT 1", {chain}))
    head = {database::integer(row, 0), database::text(row, 1)};
  return heads_[chain] = head;
}

void Change::write(const std::string& chain, const Event& event, const std::string& when, const std::string& who,
                   const std::string& rows_sha256) {
  Head& head = head_of(chain);
  database::Row row{chain,
                    head.seq + 1,
                    when,
                    who,
                    event.action,
                    event.subject,
                    database::text_or_nothing(event.reason),
                    database::text_or_nothing(event.detail),
                    database::text_or_nothing(rows_sha256),
                    database::text_or_nothing(head.sha256),
                    std::string()};
  std::string sha256 = sha256_of_event(row);
  row.back() = sha256;
  insert(database_, events, {row});
  head = {head.seq + 1, std::move(sha256)};
}

void Change::append(const std::string& chain, const Event& event, const std::vector<Rows>& tables) {
  append_at(chain, event, when_, who_, tables);
}

void Change::append_at(const std::string& chain, const Event& event, const std::string& when, const std::string& who,
                       const std::vector<Rows>& tables) {
  for (const auto& [shape, rows] : tables) insert(database_, *shape, rows);
  write(chain, event, when, who, digest_of(tables));
}

void Change::cover(const std::string& chain, const Event& event, const std::vector<Rows>& tables) {
  write(chain, event, when_, who_, digest_of(tables));
}

}  // namespace tumble::schema
