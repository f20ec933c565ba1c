#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/formats/hdf5/handle.hpp"
#include "tumble/formats/hdf5/raw.hpp"

namespace tumble::hdf5 {

/// A one-dimensional dataset of numbers, open for reading in pieces.
struct Numbers {
  Handle dataset;
  Handle space;
  int rank = 1;
  int axis = 0;            ///< the one that runs over the samples
  hsize_t count = 0;       ///< samples
  hsize_t piece = 131072;  ///< samples a read: whole chunks
  std::optional<RawSamples> raw = {};
};

/// Throws Error::bad_file; the caller says where.
[[noreturn]] void fail(const Sentence& reason);

/// Whether it is an integer or a floating-point number of no more than 16 bytes.
bool is_number(hid_t type);
/// Whether a file of `file_size` bytes can hold `count` numbers: deflate packs at most 1032 to 1.
bool plausible(hsize_t count, std::size_t file_size);

/// Sets the piece to whole chunks, and a cache that holds one while neighbouring pieces are read. `extent`: of the
/// dataset `path`, whose rank, axis and count are set. Throws Error::bad_file, the bare reason, where its samples are
/// not in this file or its chunks are implausible.
void look_at_storage(Numbers& numbers, hid_t file, const std::string& path, const std::vector<hsize_t>& extent,
                     std::size_t file_size);

/// Whether each group on the way and the last link exist.
bool exists(hid_t file, const std::string& path);

/// Whatever a link says: throws Error::bad_file, the bare reason, when the object is of another file.
void require_of_file(hid_t file, hid_t object);

/// Throws Error::bad_file, the bare reason, when it is not a vector of numbers stored in this file of `file_size`
/// bytes.
Numbers open_numbers(hid_t file, const std::string& path, std::size_t file_size);

/// Appends samples first .. first + count - 1 as value * factor + offset [SI]. NaN passes. Throws Error::bad_file, the
/// bare reason, when they cannot be read or are infinite.
void append(const Numbers& numbers, hsize_t first, hsize_t count, double factor, double offset,
            std::vector<double>& values);

/// The attribute as text or number; nothing without one of that kind. A number is [as written].
std::optional<std::string> text_attribute(hid_t object, const char* name);
std::optional<double> number_attribute(hid_t object, const char* name);

/// A dataset that holds one text; nothing for another dataset. Throws Error::bad_file, the bare reason, where it is of
/// another file.
std::optional<std::string> text_dataset(hid_t file, const char* path);

}  // namespace tumble::hdf5
