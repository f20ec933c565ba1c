#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "tumble/formats/file/input_file.hpp"

namespace tumble::file {

/// The word of the system that nobody shortens a file or opens it for writing: whoever tries waits until the lease is
/// given back. Systems, and the rights to the file, may refuse it; then files are read by copying.
class Lease {
 public:
  explicit Lease(std::shared_ptr<const InputFile> file);
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
  ~Lease();

  /// Whether it holds. Where somebody waits for the file it is given back, for good: to be asked again after every few
  /// milliseconds of work, and mappings are to be removed before.
  bool holds();

 private:
  std::shared_ptr<const InputFile> file_;
  bool held_ = false;
};

/// Bytes of a file as they lie in the memory of the system, without a copy. They may be read while a Lease holds.
class Mapping {
 public:
  Mapping() = default;
  /// Of bytes `offset` to `offset + count`; not there where the system refuses.
  Mapping(const InputFile& file, std::uint64_t offset, std::size_t count);
  Mapping(Mapping&& other) noexcept;
  Mapping& operator=(Mapping&& other) noexcept;
  ~Mapping();

  /// The byte at `offset` of the file; null: not there.
  const char* at(std::uint64_t offset) const;

 private:
  void* pages_ = nullptr;
  std::size_t length_ = 0;  ///< [bytes]
  std::uint64_t begin_ = 0;
};

}  // namespace tumble::file
