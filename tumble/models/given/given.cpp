#include "tumble/models/given/given.hpp"

#include <fmt/format.h>

#include "tumble/models/model.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::given {

Option physical(std::string name, std::string unit, std::string description) {
  return quantity(std::move(name), std::move(unit)).says(std::move(description));
}

double number_or(const Settings& truth, std::string_view name, double fallback) {
  return truth.has(name) ? truth.number(name) : fallback;
}

std::vector<std::string> given_of(const Settings& truth, const std::vector<std::string>& names) {
  std::vector<std::string> found;
  for (const auto& name : names)
    if (truth.has(name)) found.push_back(name);
  return found;
}

void require_positive(const Settings& truth, const std::vector<std::string>& names, Problems& problems) {
  for (const auto& name : given_of(truth, names))
    if (!(truth.number(name) > 0.0)) problems.push_back(say("{} must be positive", Name{name}));
}

void require_with(const Settings& truth, const std::vector<std::string>& names, const std::vector<std::string>& needed,
                  Problems& problems) {
  const auto given = given_of(truth, names);
  if (given.empty()) return;
  std::vector<std::string> missing;
  for (const auto& name : needed)
    if (!truth.has(name)) missing.push_back(name);
  if (!missing.empty())
    problems.push_back(say("{}: needs {} as well", fmt::join(given, ", "), fmt::join(missing, ", ")));
}

void refuse(Problems problems) {
  for (auto& problem : problems)
    if (about_truth(problem) == nullptr) problem = say("[truth] {}", problem.what);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

}  // namespace tumble::given

namespace tumble {

const Sentence* about_truth(const Problem& problem) {
  return problem.what.pattern == "[truth] {}" ? &problem.what.values.front().nested.front() : nullptr;
}

}  // namespace tumble
