#include "tumble/formats/file/unique_names.hpp"

namespace tumble::file {

std::string UniqueNames::take(const std::string& written) {
  if (taken_.insert(written).second) return written;
  std::size_t& last = last_.emplace(written, 1).first->second;
  for (;;) {
    const std::string name = written + "_" + std::to_string(++last);
    if (taken_.insert(name).second) return name;
  }
}

}  // namespace tumble::file
