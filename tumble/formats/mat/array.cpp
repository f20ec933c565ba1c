#include "tumble/formats/mat/array.hpp"

#include <algorithm>

#include "tumble/formats/file/input_file.hpp"

namespace tumble::mat {

namespace {

constexpr std::size_t most_named = 100;  ///< [1] chosen: more names of variables that are not read help nobody

}  // namespace

Array::Array(std::string of, std::size_t count, const std::shared_ptr<file::Spool>& spool) : name(std::move(of)) {
  for (std::size_t k = 0; k < count; ++k) vectors.push_back(std::make_shared<file::Series>(spool));
}

Contents::Contents(const std::string& path, Keep where)
    : keep(where),
      spool(where == Keep::in_spool ? std::make_shared<file::Spool>(path) : nullptr),
      budget(file::InputFile(path).size()) {}

void Contents::keep_array(Array array) {
  budget.take_text(array.name.size());
  arrays.push_back(std::move(array));
}

void Contents::keep_text(const std::string& variable, std::string text) {
  budget.take_text(variable.size() + text.size());
  texts.emplace_back(variable, std::move(text));
}

void Contents::leave_out(const std::string& variable) {
  if (skipped.size() == most_named) {
    ++skipped_too;
    return;
  }
  budget.take_text(variable.size());
  skipped.push_back(variable);
}

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
