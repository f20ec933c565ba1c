#include "tumble/formats/temporary_folder.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "tumble/units/error.hpp"

namespace tumble {

TemporaryFolder::TemporaryFolder(const Sentence& failing) {
  constexpr const char* begin = "tumble-work-";
  std::error_code problem;
  const std::filesystem::path room = std::filesystem::temp_directory_path(problem);
  if (!problem) sweep_unfinished(room, begin, "");
  std::string pattern = (room / (std::string(begin) + "XXXXXX")).string();
  if (!problem && mkdtemp(pattern.data()) == nullptr) problem = {errno, std::system_category()};
  if (problem) throw Error(Error::Kind::bad_file, say("{}: {}", failing, system_reason(problem)));
  path_ = pattern;
  descriptor_ = open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ >= 0) lock_unfinished(descriptor_);
  unfinished_ = Unfinished(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace tumble
