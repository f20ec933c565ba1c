#pragma once

#include <toml++/toml.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/settings.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::tables {

/// Problems of a file of TOML (a plan, a declaration of frames), each problem with the line where it stands.
struct FileProblems {
  std::string file;
  Problems all;

  /// "plan.toml:12"
  std::string place(const toml::source_region& at) const;
  /// At this line of the file.
  Where where(const toml::source_region& at) const;
  void add(const toml::source_region& at, Problem problem);
  /// In the order of their lines; those without a line last.
  Problems sorted() const;
};

/// One table of such a file. Hands out its values by key, checked, and remembers which keys were asked for: every other
/// key is a problem when the section is closed. A value that is not what was asked for is a problem, too, and then
/// absent.
class Section {
 public:
  /// `name` for messages: "[site]"; empty for the file itself. A sentence where a name of the user stands in quotes in
  /// it: say("[[frame]] '{}'", title).
  Section(const toml::table& table, Sentence name, FileProblems& problems);
  Section(const toml::table& table, const std::string& name, FileProblems& problems);
  Section(const toml::table& table, const char* name, FileProblems& problems);

  /// Null when the key is absent.
  const toml::node* find(std::string_view key);
  std::optional<std::string> text(std::string_view key);
  /// One text or a list of them.
  std::vector<std::string> texts(std::string_view key);
  std::optional<int> integer(std::string_view key);
  /// A quantity, or a list of them [SI], of the dimension of `expected`.
  std::optional<double> quantity(std::string_view key, const Unit& expected);
  std::vector<double> quantities(std::string_view key, const Unit& expected);
  /// One integer or a list of them.
  std::vector<int> integers(std::string_view key);
  /// The nested table of that name; null when absent or no table.
  const toml::table* table(std::string_view key);

  /// All keys not asked for yet, for somebody else to check.
  std::vector<Given> rest();
  /// The keys not asked for yet.
  std::vector<std::string> unread() const;
  /// Every key not asked for is a problem, with the nearest of those that were.
  void close();

  void missing(std::string_view key, const char* example);
  void missing(std::string_view key, const std::string& example);
  void problem(const Problem& problem);
  void problem_at(std::string_view key, const Problem& problem);
  std::string name() const { return name_.text(); }
  const toml::source_region& source() const { return table_.source(); }

 private:
  std::optional<double> si_of(const toml::node& node, std::string_view key, const Unit& expected);
  std::optional<int> int_of(const toml::node& node, std::string_view key);
  void complain(const toml::node& node, std::string_view key, const Problem& problem);

  const toml::table& table_;
  Where named(std::string_view key) const;

  Sentence name_;
  FileProblems& problems_;
  std::vector<std::string> known_;
};

/// Value of a node as text: strings as they are, lists of numbers separated by commas.
std::optional<std::string> text_of(const toml::node& node);

}  // namespace tumble::tables
