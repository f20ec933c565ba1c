#pragma once

#include <cstddef>
#include <cstdint>

namespace tumble::file {

/// Counts what is kept of a file and refuses what no file of its size holds: a few bytes can unpack to very many, and many
/// names can link to the same bytes.
class Budget {
 public:
  /// Given   file_size  [bytes]
  ///         packing    [1] numbers that a byte of the file may unpack to, above what any file may
  explicit Budget(std::uintmax_t file_size, std::uintmax_t packing = usual_packing);

  /// rows x columns numbers [1] that are kept. Throws Error::bad_file, the bare reason.
  void take_numbers(std::uintmax_t rows, std::uintmax_t columns);
  /// A name or a text of so many bytes that is kept. Throws Error::bad_file, the bare reason.
  void take_text(std::size_t bytes);

  static constexpr std::uintmax_t usual_packing =
      16;  ///< [1/byte] chosen: eight bytes a number, packed to a half of a byte
  static constexpr std::uintmax_t deflate_packing = 1032;  ///< [1/byte] the most of deflate, in numbers of one byte

 private:
  std::uintmax_t numbers_left_;  ///< [1]
  std::uintmax_t texts_left_;    ///< [bytes]
};

}  // namespace tumble::file
