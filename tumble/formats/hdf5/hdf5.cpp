#include <cstring>

#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/hdf5/read.hpp"

namespace tumble::hdf5 {

namespace {

/// The signature may stand behind a user block; that of a MATLAB file says so, and is of another format.
bool recognises(const std::string& path) {
  file::InputFile file(path);
  std::string bytes(2048 + 8, '\0');
  const std::size_t count = file.read(bytes.data(), bytes.size());
  if (bytes.starts_with("MATLAB 7.")) return false;
  for (const std::size_t offset : {0, 512, 1024, 2048})
    if (offset + 8 <= count && std::memcmp(bytes.data() + offset, "\211HDF\r\n\032\n", 8) == 0) return true;
  return false;
}

}  // namespace

extern const Format hdf5{"hdf5",
                         "HDF5: one dataset for each channel in /channels, with attributes unit, quantity, rate",
                         {".h5", ".hdf5", ".hdf"},
                         recognises,
                         tumble::hdf5::read,
                         tumble::hdf5::memory,
                         tumble::hdf5::stream,
                         tumble::hdf5::writer};

}  // namespace tumble::hdf5
