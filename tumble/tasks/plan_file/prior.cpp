#include "tumble/tasks/plan_file/prior.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "tumble/tasks/plan_file/file_named.hpp"

namespace tumble::plan_file {
namespace {

/// "archive", or a file found from the plan's folder; empty, with a problem, where it may not be opened.
std::string source_of(tables::Section& section, const char* key, const std::string& text, const std::string& folder) {
  return text == "archive" ? text : file_named(section, key, folder).value_or("");
}

PriorChoice of_table(const toml::table& table, const std::string& folder, tables::FileProblems& problems) {
  tables::Section section(table, "[prior]", problems);
  PriorChoice choice;
  if (const auto from = section.text("from"))
    choice.from = source_of(section, "from", *from, folder);
  else if (!table.contains("from"))
    section.missing("from", "\"archive\"");
  if (const auto verdicts = section.text("verdicts")) {
    if (*verdicts != "with" && *verdicts != "without")
      section.problem_at("verdicts", "is \"without\" (the estimate without prior, the default) or \"with\"");
    choice.verdicts = *verdicts == "with";
  }
  section.close();
  return choice;
}

}  // namespace

Sentence refusal_of_prior(const Method& method) {
  if (method.takes_prior) return {};
  std::vector<std::string> names;
  for (const auto* one : method_catalogue())
    if (one->takes_prior) names.emplace_back(one->name);
  return say("{} does not use a prior; {} do", Name{std::string(method.name)}, fmt::join(names, ", "));
}

PriorChoice read_prior(tables::Section& root, const std::string& folder, const Method* method,
                       tables::FileProblems& problems) {
  const auto* node = root.find("prior");
  if (!node) return {};
  PriorChoice choice;
  if (const auto* table = node->as_table())
    choice = of_table(*table, folder, problems);
  else if (const auto text = node->value<std::string>(); text && node->is_string() && !text->empty())
    choice.from = source_of(root, "prior", *text, folder);
  else
    root.problem_at("prior", "is \"archive\", the name of a file, or a table [prior] with from and verdicts");
  if (method)
    if (const auto refusal = refusal_of_prior(*method); !refusal.empty()) root.problem_at("prior", refusal);
  return choice;
}

}  // namespace tumble::plan_file
