#include "tumble/formats/file/series.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "tumble/math/room.hpp"
#include "tumble/units/error.hpp"

namespace tumble::file {

std::uint64_t Spool::write(const double* values, std::size_t count) {
  assert(!input_);
  if (!file_) file_ = std::make_unique<TemporaryFile>("samples", from_);
  file_->write({reinterpret_cast<const char*>(values), count * sizeof(double)});
  return std::exchange(written_, written_ + count);
}

void Spool::read(std::uint64_t first, std::size_t count, double* to) {
  if (!input_) {
    file_->close();
    input_ = std::make_unique<InputFile>(file_->path());
  }
  const std::size_t bytes = count * sizeof(double);
  if (input_->read_at(first * sizeof(double), reinterpret_cast<char*>(to), bytes) != bytes)
    throw Error(Error::Kind::bad_file, say("'{}': its samples in the folder for temporary files were removed", from_));
}

void Series::make_room(std::size_t count) {
  if (!spool_) tumble::make_room(pending_, count);
}

void Series::flush() {
  places_.push_back(spool_->write(pending_.data(), pending_.size()));
  pending_.clear();
}

void Series::add(const double* values, std::size_t count) {
  double largest = 0.0;
  for (std::size_t k = 0; k < count; ++k) largest = std::max(largest, std::abs(values[k]));
  if (std::isinf(largest))
    infinite_ +=
        static_cast<std::size_t>(std::count_if(values, values + count, [](double v) { return std::isinf(v); }));
  size_ += count;
  while (count > 0) {
    const std::size_t now = spool_ ? std::min(count, chunk - pending_.size()) : count;
    pending_.insert(pending_.end(), values, values + now);
    if (spool_ && pending_.size() == chunk) flush();
    values += now;
    count -= now;
  }
}

void Series::read(std::size_t first, std::size_t count, std::vector<double>& to) const {
  while (count > 0) {
    const std::size_t place = first / chunk, inner = first % chunk;
    if (place >= places_.size()) {
      const auto begin = pending_.begin() + static_cast<std::ptrdiff_t>(first - places_.size() * chunk);
      to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
      return;
    }
    const std::size_t now = std::min(count, chunk - inner);
    to.resize(to.size() + now);
    spool_->read(places_[place] + inner, now, to.data() + to.size() - now);
    first += now;
    count -= now;
  }
}

double Series::at(std::size_t index) const {
  std::vector<double> value;
  read(index, 1, value);
  return value.front();
}

std::vector<double> Series::take() {
  std::vector<double> values;
  if (places_.empty())
    values = std::move(pending_);
  else
    read(0, size_, values);
  *this = Series(spool_);
  return values;
}

}  // namespace tumble::file
