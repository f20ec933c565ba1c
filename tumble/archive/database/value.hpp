#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

namespace tumble::database {

/// Bytes that are no text.
struct Bytes {
  std::string data;
  bool operator==(const Bytes&) const = default;
};

/// A cell: nothing, a whole number, a number, a text, bytes.
using Value = std::variant<std::monostate, std::int64_t, double, std::string, Bytes>;
using Row = std::vector<Value>;
using RowSink = std::function<void(const Row&)>;

/// Why a database does not do what it was asked for.
struct Refusal {
  enum class Kind {
    conflict,  ///< another writer was first: the transaction may be repeated
    failed
  };
  Kind kind = Kind::failed;
  std::string text;
};

/// A text; nothing where it is empty.
Value text_or_nothing(const std::string& text);
/// A number [u]; nothing where it is not finite. Zero has no sign.
Value number_or_nothing(double value);

/// A cell of a row that must have this type. An empty cell gives an empty text, 0 and NaN. Throws Refusal otherwise.
const std::string& text(const Row& row, std::size_t column);
std::int64_t integer(const Row& row, std::size_t column);
double number(const Row& row, std::size_t column);  ///< any unit, as the table has it [u]
const std::string& bytes(const Row& row, std::size_t column);

}  // namespace tumble::database
