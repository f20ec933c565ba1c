#pragma once

#include <hdf5.h>

#include <cstddef>
#include <optional>

#include "tumble/formats/hdf5/handle.hpp"

namespace tumble::hdf5 {

/// Where the samples of a dataset lie in its file: float64 of this processor, one after the other, or in chunks that
/// are as they are, deflated, or shuffled and deflated. They are read without the library, several chunks at once.
struct RawSamples {
  int descriptor = -1;  ///< of the file, which the library has open
  std::size_t file_size = 0;
  haddr_t place = 0;  ///< of the first sample, where there are no chunks
  hsize_t count = 0;  ///< samples
  hsize_t chunk = 0;  ///< samples a chunk; 0: there are no chunks
  bool deflated = false, shuffled = false;
};

/// Place of the samples of a dataset with this creation list, type and one axis of `count` samples; nothing where the
/// library must read it.
std::optional<RawSamples> raw_samples(hid_t file, hid_t dataset, hid_t plist, int rank, hsize_t count,
                                      std::size_t file_size);

/// Writes samples first .. first + count - 1 [as written] to `to`. False: it was not possible, and the library, which
/// reads them too, says why.
bool read_raw(const RawSamples& samples, hid_t dataset, hsize_t first, hsize_t count, double* to);

}  // namespace tumble::hdf5
