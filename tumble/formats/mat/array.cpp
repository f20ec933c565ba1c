#include "tumble/formats/mat/array.hpp"

#include <algorithm>

#include "tumble/units/error.hpp"

namespace tumble::mat {

namespace {

constexpr std::size_t always = std::size_t{1} << 27;  ///< values [1 GB] that any file may unpack to
constexpr std::size_t per_byte = 16;                  ///< values that a byte of the file may unpack to, above that

}  // namespace

Budget::Budget(std::size_t file_size) : left_(std::max(always, per_byte * file_size)) {}

void Budget::take(std::size_t rows, std::size_t columns) {
  if (columns != 0 && rows > left_ / columns)
    throw Error(Error::Kind::bad_file, say("it claims {} x {} numbers, more than a file of this size can hold",
                                           Name{std::to_string(rows)}, Name{std::to_string(columns)}));
  left_ -= rows * columns;
}

Array::Array(std::string of, std::size_t count, const std::shared_ptr<file::Spool>& spool) : name(std::move(of)) {
  for (std::size_t k = 0; k < count; ++k) vectors.push_back(std::make_shared<file::Series>(spool));
}

Contents::Contents(const std::string& path, Keep where)
    : keep(where), spool(where == Keep::in_spool ? std::make_shared<file::Spool>(path) : nullptr) {}

Filler::Filler(Array& to, std::size_t rows, std::size_t columns, std::size_t room)
    : to_(to), rows_(rows), by_column_(rows >= columns) {
  const std::size_t each = std::min(std::max(rows, columns), room / std::max<std::size_t>(1, to_.vectors.size()));
  for (auto& vector : to_.vectors) vector->make_room(each);
}

void Filler::add(const double* values, std::size_t count) {
  if (!by_column_) {
    for (std::size_t k = 0; k < count; ++k) to_.vectors[next_++ % rows_]->add(values[k]);
    return;
  }
  while (count > 0) {
    const std::size_t now = std::min(count, rows_ - next_ % rows_);
    to_.vectors[next_ / rows_]->add(values, now);
    next_ += now;
    values += now;
    count -= now;
  }
}

}  // namespace tumble::mat
