#include "tumble/tasks/plan_file/file_named.hpp"

#include "tumble/formats/confinement.hpp"
#include "tumble/units/error.hpp"

namespace tumble::plan_file {

std::optional<std::string> file_named(tables::Section& section, const char* key, const std::filesystem::path& folder) {
  const auto name = section.text(key);
  if (!name) return std::nullopt;
  try {
    return file_named_in(folder, *name);
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at(key, problem);
    return std::nullopt;
  }
}

}  // namespace tumble::plan_file
