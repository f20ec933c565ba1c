#include "tumble/archive/database/value.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace tumble::database {

namespace {

template <typename T>
const T& cell(const Row& row, std::size_t column, const T& none) {
  const Value& value = row.at(column);
  if (std::holds_alternative<std::monostate>(value)) return none;
  if (const T* const typed = std::get_if<T>(&value)) return *typed;
  throw Refusal{Refusal::Kind::failed,
                fmt::format("column {} of a row has another type than its table says", column + 1)};
}

}  // namespace

Value text_or_nothing(const std::string& text) { return text.empty() ? Value() : Value(text); }
Value number_or_nothing(double value) { return std::isfinite(value) ? Value(value + 0.0) : Value(); }

const std::string& text(const Row& row, std::size_t column) {
  static const std::string none;
  return cell(row, column, none);
}

std::int64_t integer(const Row& row, std::size_t column) {
  static constexpr std::int64_t none = 0;
  return cell(row, column, none);
}

double number(const Row& row, std::size_t column) {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  return cell(row, column, none);
}

const std::string& bytes(const Row& row, std::size_t column) {
  static const Bytes none;
  return cell(row, column, none).data;
}

}  // namespace tumble::database
