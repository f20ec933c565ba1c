#include "tumble/formats/temporary_folder.hpp"

#include <stdlib.h>

#include <cerrno>
#include <system_error>

#include "tumble/units/error.hpp"

namespace tumble {

TemporaryFolder::TemporaryFolder(const Sentence& failing) {
  std::error_code problem;
  std::string pattern = (std::filesystem::temp_directory_path(problem) / "tumble-XXXXXX").string();
  if (!problem && mkdtemp(pattern.data()) == nullptr) problem = {errno, std::system_category()};
  if (problem) throw Error(Error::Kind::bad_file, say("{}: {}", failing, system_reason(problem)));
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace tumble
