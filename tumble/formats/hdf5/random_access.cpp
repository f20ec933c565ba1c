#include "tumble/formats/random_access.hpp"

#include <cstring>
#include <memory>

#include "tumble/formats/format.hpp"
#include "tumble/formats/hdf5/read.hpp"

namespace tumble {

SampleReader sample_reader(const std::string& path, const ReadOptions& options) {
  if (std::strcmp(format_of(path, options).name, "hdf5") != 0) return {};
  return hdf5::samples(path, options);
}

}  // namespace tumble
