#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/temporary_file.hpp"

namespace tumble::file {

/// A temporary file that takes the samples of all channels of a recording larger than memory; made when the first come.
class Spool {
 public:
  /// `from`: what the samples come from, for messages.
  explicit Spool(std::string from) : from_(std::move(from)) {}

  /// Number of values [1] that stood in the file before these. Nothing can be written once something was read.
  /// Throws Error::bad_file, for a full disk too.
  std::uint64_t write(const double* values, std::size_t count);
  /// The `count` values [as written] from value number `first` [1] on. Throws Error::bad_file.
  void read(std::uint64_t first, std::size_t count, double* to);

 private:
  std::string from_;
  std::uint64_t written_ = 0;  ///< values
  std::unique_ptr<TemporaryFile> file_;
  std::unique_ptr<InputFile> input_;
};

/// Numbers in the order in which they come: in memory, or in a spool except for the last of them.
class Series {
 public:
  /// Null: in memory.
  explicit Series(std::shared_ptr<Spool> spool = nullptr) : spool_(std::move(spool)) {}

  /// Room in memory for `count` values [1] at once; nothing where they go to a spool.
  void make_room(std::size_t count);
  /// `values` [any]. Throws Error::bad_file where the spool cannot take them.
  void add(const double* values, std::size_t count);
  /// `value` [any]. Throws as the other.
  void add(double value) {
    pending_.push_back(value);
    infinite_ += std::isinf(value);
    ++size_;
    if (spool_ && pending_.size() == chunk) flush();
  }

  std::size_t size() const { return size_; }
  std::size_t infinite() const { return infinite_; }  ///< number of infinite values [1]
  /// Appends values `first` to `first + count` to `to` [as written]. Throws Error::bad_file.
  void read(std::size_t first, std::size_t count, std::vector<double>& to) const;
  /// One value [as written], `index` < size().
  double at(std::size_t index) const;
  /// All values [as written]; the series is empty then.
  std::vector<double> take();

 private:
  static constexpr std::size_t chunk = 1024;  ///< values that go to the spool at once

  void flush();

  std::shared_ptr<Spool> spool_;
  std::vector<std::uint64_t> places_;  ///< in the spool, of each chunk
  std::vector<double> pending_;
  std::size_t size_ = 0, infinite_ = 0;
};

}  // namespace tumble::file
