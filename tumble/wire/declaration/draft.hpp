#pragma once

#include <toml++/toml.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tumble/core/tables/section.hpp"
#include "tumble/units/error.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble::declaration {

/// A declaration of frames or of a controller while it is read: its file and its problems.
struct Draft {
  tables::FileProblems problems;

  explicit Draft(std::string file) : problems{std::move(file), {}} {}
  /// One of its tables. `name` for messages: "[link]".
  tables::Section section(const toml::table& table, std::string name) { return {table, std::move(name), problems}; }
  /// A problem of the whole file.
  void add(const Problem& problem) { problems.all.push_back(in_file(problems.file, problem)); }
  bool sound() const { return problems.all.empty(); }
  /// Throws Error::bad_input with all problems, in the order of their lines.
  void require_sound() const {
    if (!sound()) throw Error(Error::Kind::bad_input, problems.sorted());
  }
};

/// Bytes from "FE 81 FF 55"; with `mask` a '.' is a digit that may be any. Throws Error::bad_input.
std::string parse_hex(std::string_view text, std::string* mask = nullptr);

/// Bytes of a text without fields: those of Latin-1. None with a problem where it holds other letters.
std::string bytes_at(tables::Section& section, std::string_view key);

/// How certain a declaration or a part of it is; `otherwise` where it does not say.
FrameCertainty certainty_at(tables::Section& section, FrameCertainty otherwise);

/// The tables at `key`: one, or a list of them.
std::vector<const toml::table*> tables_at(tables::Section& section, std::string_view key);

/// Runs `parse`; what it throws becomes a problem of the key.
template <class Parse>
void parse_at(tables::Section& section, std::string_view key, Parse parse) {
  try {
    parse();
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at(key, problem);
  }
}

/// The keys that every declaration has: title, source, note and certainty, into members of these names. Given: example
/// of a title.
template <class Head>
void read_head(tables::Section& root, const char* example, Head& to) {
  to.title = root.text("title").value_or("");
  to.source = root.text("source").value_or("");
  to.note = root.text("note").value_or("");
  if (to.title.empty()) root.missing("title", example);
  if (!root.find("certainty")) root.missing("certainty", "\"maker\"");
  to.certainty = certainty_at(root, FrameCertainty::uncertain);
}

}  // namespace tumble::declaration
