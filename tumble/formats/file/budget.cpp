#include "tumble/formats/file/budget.hpp"

#include <algorithm>
#include <string>

#include "tumble/units/error.hpp"

namespace tumble::file {
namespace {

constexpr std::uintmax_t numbers_of_any_file = std::uintmax_t{1} << 27;  ///< [1] 1 GB
constexpr std::uintmax_t texts_of_any_file = std::uintmax_t{1} << 26;    ///< [bytes] 64 MB
constexpr std::uintmax_t place_of_a_text = 64;                           ///< [bytes] that a text takes beside its own

}  // namespace

Budget::Budget(std::uintmax_t file_size, std::uintmax_t packing)
    : numbers_left_(std::max(numbers_of_any_file, packing * file_size)),
      texts_left_(std::max(texts_of_any_file, file_size)) {}

void Budget::take_numbers(std::uintmax_t rows, std::uintmax_t columns) {
  if (columns != 0 && rows > numbers_left_ / columns)
    throw Error(Error::Kind::bad_file, say("it claims {} x {} numbers, more than a file of this size can hold",
                                           Name{std::to_string(rows)}, Name{std::to_string(columns)}));
  numbers_left_ -= rows * columns;
}

void Budget::take_text(std::size_t bytes) {
  const std::uintmax_t taken = place_of_a_text + bytes;
  if (taken > texts_left_)
    throw Error(Error::Kind::bad_file, "its names and texts are longer than a file of this size can hold");
  texts_left_ -= taken;
}

}  // namespace tumble::file
