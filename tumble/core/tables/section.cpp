#include "tumble/core/tables/section.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <sstream>

#include "tumble/units/error.hpp"

namespace tumble::tables {

std::string FileProblems::place(const toml::source_region& at) const { return where(at).place.text(); }

Where FileProblems::where(const toml::source_region& at) const {
  const auto line = at.begin.line;  // 0: given on the command line
  return {.file = file, .line = line, .place = line == 0 ? say("{}", Name{file}) : say("{}:{}", Name{file}, line)};
}

void FileProblems::add(const toml::source_region& at, Problem problem) {
  problem = within(where(at), std::move(problem));
  constexpr std::size_t most = 200;
  if (all.size() > most || std::find(all.begin(), all.end(), problem) != all.end())
    return;  // a segment of many runs: once
  if (all.size() < most)
    all.push_back(std::move(problem));
  else
    all.push_back(say("there are more than {} problems: correct these first", most));
}

Problems FileProblems::sorted() const {
  const auto line = [this](const Problem& problem) {
    const bool here = problem.where.file == file && problem.where.line > 0;
    return here ? problem.where.line : std::numeric_limits<std::size_t>::max();
  };
  auto all_sorted = all;
  std::stable_sort(all_sorted.begin(), all_sorted.end(),
                   [&](const Problem& a, const Problem& b) { return line(a) < line(b); });
  return all_sorted;
}

Section::Section(const toml::table& table, Sentence name, FileProblems& problems)
    : table_(table), name_(std::move(name)), problems_(problems) {}
Section::Section(const toml::table& table, const std::string& name, FileProblems& problems)
    : Section(table, name.empty() ? Sentence() : say("{}", Name{name}), problems) {}
Section::Section(const toml::table& table, const char* name, FileProblems& problems)
    : Section(table, std::string(name), problems) {}

const toml::node* Section::find(std::string_view key) {
  known_.emplace_back(key);
  return table_.get(key);
}

void Section::complain(const toml::node& node, std::string_view key, const Problem& problem) {
  problems_.add(node.source(), within(named(key), problem));
}

Where Section::named(std::string_view key) const {
  const std::string shown(key);
  Where where{.table = name_.text(), .key = shown};
  if (!name_.empty()) where.place = shown.empty() ? name_ : say("{}: {}", name_, Name{shown});
  if (name_.empty() && !shown.empty()) where.place = say("{}", Name{shown});
  return where;
}

std::optional<std::string> Section::text(std::string_view key) {
  const auto* node = find(key);
  if (!node) return std::nullopt;
  if (const auto* string = node->as_string()) return string->get();
  complain(*node, key, "a text in quotes is expected");
  return std::nullopt;
}

std::vector<std::string> Section::texts(std::string_view key) {
  std::vector<std::string> values;
  const auto* node = find(key);
  if (!node) return values;
  const auto add = [&](const toml::node& element) {
    if (const auto* string = element.as_string())
      values.push_back(string->get());
    else
      complain(element, key, "a text in quotes, or a list of them, is expected");
  };
  if (const auto* array = node->as_array())
    for (const auto& element : *array) add(element);
  else
    add(*node);
  return values;
}

std::optional<int> Section::int_of(const toml::node& node, std::string_view key) {
  const auto* integer = node.as_integer();
  if (integer && integer->get() >= 0 && integer->get() <= std::numeric_limits<int>::max())
    return static_cast<int>(integer->get());
  complain(node, key, "a whole number is expected");
  return std::nullopt;
}

std::optional<int> Section::integer(std::string_view key) {
  const auto* node = find(key);
  return node ? int_of(*node, key) : std::nullopt;
}

std::vector<int> Section::integers(std::string_view key) {
  std::vector<int> values;
  const auto* node = find(key);
  if (!node) return values;
  const auto add = [&](const toml::node& element) {
    if (const auto value = int_of(element, key)) values.push_back(*value);
  };
  if (const auto* array = node->as_array())
    for (const auto& element : *array) add(element);
  else
    add(*node);
  return values;
}

std::optional<double> Section::si_of(const toml::node& node, std::string_view key, const Unit& expected) {
  const auto text = text_of(node);
  if (!text || node.is_array()) {
    complain(node, key, say("a quantity is expected, for example \"1 {}\"", Name{expected.text()}));
    return std::nullopt;
  }
  const bool needs_unit = expected.dimension() != Dimension{};
  if (!node.is_string() && needs_unit) {
    complain(node, key, say("a bare number needs its unit: \"{} {}\"", Name{*text}, Name{expected.text()}));
    return std::nullopt;
  }
  try {
    return parse_si(*text, expected);
  } catch (const Error& error) {
    for (const auto& problem : error.problems) complain(node, key, problem);
    return std::nullopt;
  }
}

std::optional<double> Section::quantity(std::string_view key, const Unit& expected) {
  const auto* node = find(key);
  return node ? si_of(*node, key, expected) : std::nullopt;
}

std::vector<double> Section::quantities(std::string_view key, const Unit& expected) {
  std::vector<double> values;
  const auto* node = find(key);
  if (!node) return values;
  const auto* array = node->as_array();
  if (!array) {
    complain(*node, key, say("a list of quantities is expected: [\"1 {0}\", \"2 {0}\"]", Name{expected.text()}));
    return values;
  }
  for (const auto& element : *array)
    if (const auto value = si_of(element, key, expected)) values.push_back(*value);
  return values;
}

const toml::table* Section::table(std::string_view key) {
  const auto* node = find(key);
  if (!node) return nullptr;
  if (!node->is_table())
    complain(*node, key, say("a table is expected, for example {}", Name{fmt::format("{{{} = ...}}", key)}));
  return node->as_table();
}

std::vector<std::string> Section::unread() const {
  std::vector<std::string> keys;
  for (const auto& [key, node] : table_)
    if (std::find(known_.begin(), known_.end(), key.str()) == known_.end()) keys.emplace_back(key.str());
  return keys;
}

std::vector<Given> Section::rest() {
  std::vector<Given> given;
  for (const auto& key : unread()) {
    const auto& node = *find(key);
    if (const auto text = text_of(node))
      given.push_back({key, *text, problems_.where(node.source()), node.is_string()});
    else
      complain(node, key, "a value is expected, not a table or a list of lists");
  }
  return given;
}

void Section::close() {
  auto known = known_;
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  for (const auto& [key, node] : table_) {
    if (std::binary_search(known.begin(), known.end(), key.str())) continue;
    const auto advice = did_you_mean(key.str(), known);
    const std::string key_name(key.str());
    problems_.add(key.source(), within(named(""), advice.empty() ? say("unknown key '{}'; known are {}", key_name,
                                                                       fmt::join(known, ", "))
                                                                 : say("unknown key '{}'{}", key_name, advice)));
  }
}

void Section::missing(std::string_view key, const char* example) {
  problem(say("{0} is missing, for example {0} = {1}", Name{std::string(key)}, example));
}

void Section::missing(std::string_view key, const std::string& example) {
  problem(say("{0} is missing, for example {0} = {1}", Name{std::string(key)}, Name{example}));
}

void Section::problem(const Problem& problem) { problems_.add(table_.source(), within(named(""), problem)); }

void Section::problem_at(std::string_view key, const Problem& problem) {
  const auto* node = table_.get(key);
  problems_.add(node ? node->source() : table_.source(), within(named(key), problem));
}

std::optional<std::string> text_of(const toml::node& node) {
  if (const auto* string = node.as_string()) return string->get();
  if (node.is_table()) return std::nullopt;
  if (const auto* array = node.as_array()) {
    std::vector<std::string> parts;
    for (const auto& element : *array) {
      const auto part = element.is_array() ? std::nullopt : text_of(element);
      if (!part) return std::nullopt;
      parts.push_back(*part);
    }
    return fmt::format("{}", fmt::join(parts, ", "));
  }
  std::ostringstream text;  // as TOML writes it, which is what stood in the file up to spelling
  node.visit([&](const auto& value) { text << value; });
  return text.str();
}

}  // namespace tumble::tables
