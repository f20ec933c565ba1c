#include "tumble/tasks/plan_file/files_like.hpp"

#include <glob.h>
#include <string.h>  // strverscmp

#include <algorithm>
#include <filesystem>

#include "tumble/formats/confinement.hpp"

namespace tumble::plan_file {

std::vector<std::string> files_like(const std::string& name) {
  std::error_code unknown;
  if (name.find_first_of("*?[") == std::string::npos || std::filesystem::exists(name, unknown)) return {name};
  std::vector<std::string> files;
  glob_t found{};
  if (glob(name.c_str(), 0, nullptr, &found) == 0) files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  globfree(&found);
  std::erase_if(files, [](const std::string& file) { return !may_be_named(file); });
  std::ranges::sort(files, [](const auto& a, const auto& b) { return strverscmp(a.c_str(), b.c_str()) < 0; });
  return files;
}

}  // namespace tumble::plan_file
