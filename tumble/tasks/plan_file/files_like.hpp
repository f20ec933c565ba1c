#pragma once

#include <string>
#include <vector>

namespace tumble::plan_file {

/// The files that a name with `*`, `?` or `[...]` means, in the order of their names, numbers by their size: run-9
/// before run-10. A name without these, or that is itself a file, means itself. Empty: there is no such file.
std::vector<std::string> files_like(const std::string& name);

}  // namespace tumble::plan_file
