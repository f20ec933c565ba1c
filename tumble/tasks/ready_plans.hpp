#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tumble {

/// A plan that travels inside the program: to start from, or to rehearse a test with `simulate` and `predict`.
struct ReadyPlan {
  std::string_view name;  ///< of its file, without .toml
  std::string method;     ///< empty: a recording for several methods
  std::string title;
  std::string_view text;  ///< TOML with comments
  std::vector<std::string>
      beside;  ///< files of other ready plans that its recordings name: they belong into its folder
};

/// All ready plans by name.
const std::vector<ReadyPlan>& ready_plans();

/// The plan of that name, else the first one for the method of that name. Throws Error::unsupported with the nearest
/// names.
const ReadyPlan& find_ready_plan(const std::string& name_or_method);

}  // namespace tumble
