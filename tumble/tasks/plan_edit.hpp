#pragma once

#include <cstddef>
#include <string>
#include <vector>

/// One change of the text of a plan. Everything else stays as it is: comments, spaces, order. Each function reads the
/// result again and compares it with the change made to the tables, so that a text which it does not understand is
/// refused and never spoiled. `file` is for messages.
namespace tumble {

/// Where a value is: keys, and numbers of elements from 0: {"schedule", "3", "outer"}.
using PlanPath = std::vector<std::string>;

/// A text as TOML writes it: in quotes, with escapes.
std::string toml_text(const std::string& text);

/// The plan with this value, which is written as TOML ("\"40 deg/s\"", "3", "{hold = \"0 deg\"}"). A section that the
/// plan does not have is added.
/// Throws Error::bad_input where text or value are not TOML, or where it cannot be written there.
std::string with_value(const std::string& text, const std::string& file, const PlanPath& path,
                       const std::string& value);

/// The plan without this value; a comment behind it remains. Nothing changes where it is not there.
/// Throws Error::bad_input.
std::string without_value(const std::string& text, const std::string& file, const PlanPath& path);

/// A list of tables: [[schedule]], [[limit]].
struct PlanList {
  std::string name;
  std::size_t index = 0;  ///< of one of them, from 0
};

/// With a copy of one table behind it. Throws Error::bad_input.
std::string with_copy(const std::string& text, const std::string& file, const PlanList& which);
/// Without it; comments above it remain. Throws Error::bad_input.
std::string without_table(const std::string& text, const std::string& file, const PlanList& which);
/// With it and the next one exchanged. Throws Error::bad_input.
std::string with_next_before(const std::string& text, const std::string& file, const PlanList& which);
/// With one more, of these lines, at the end of the list. Throws Error::bad_input.
std::string with_table(const std::string& text, const std::string& file, const std::string& list,
                       const std::string& lines);

}  // namespace tumble
