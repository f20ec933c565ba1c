#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/progress.hpp"

namespace tumble::uff58 {

/// Facts about the bytes of a binary dataset (58b), behind its eleven lines of text, by its first line.
struct BinaryHead {
  bool reversed = false;  ///< big-endian
  std::size_t bytes = 0;  ///< [bytes]
};

/// Given  line  "58b     1     2          11        2000 ...". Throws Error::bad_file, the bare reason, where the
/// numbers are not those of IEEE 754.
BinaryHead binary_head(std::string_view line);

/// [bytes] of a number in the binary samples of a dataset of `count` samples, where its bytes are as many as they take;
/// 0: they are not. `mixed`: abscissae of 4 bytes before samples of 8.
struct BinaryNumbers {
  std::size_t size = 0;
  bool mixed = false;
};
BinaryNumbers binary_numbers(const BinaryHead& head, bool double_precision, bool even, std::size_t count);

/// The numbers [as written] in a piece of such bytes, which holds whole pairs.
void decode_binary(std::string_view bytes, const BinaryNumbers& kind, bool reversed, std::vector<double>& numbers);

/// Functions that get the parts of a file with binary datasets.
struct Parts {
  std::function<void(std::string_view line, std::size_t number)> line;
  std::function<std::size_t()> bytes_due;       ///< [bytes] asked after each line: so many follow it as they are
  std::function<void(std::string_view)> bytes;  ///< of these; each piece but the last is a multiple of 48 long
};

/// Goes through a file of lines with bytes between them. Throws Error::bad_file.
void each_part(const std::string& path, const Progress& progress, const Parts& parts);

/// Whether a line of the file begins a binary dataset. Throws Error::bad_file.
bool has_binary_datasets(const std::string& path);

}  // namespace tumble::uff58
