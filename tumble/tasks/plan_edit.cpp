#include "tumble/tasks/plan_edit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <set>
#include <span>

#include "tumble/core/tables/document.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace plan_edit {
namespace {

/// A text with its lines, in which positions of the parser are found.
class Text {
 public:
  Text(const std::string& text, std::string file) : text_(text), file_(std::move(file)) {
    if (!text_.empty() && text_.back() != '\n') text_ += '\n';
    tables_ = tables::document_of(text_, file_);
    begins_.push_back(0);
    for (std::size_t i = 0; i < text_.size(); ++i)
      if (text_[i] == '\n') begins_.push_back(i + 1);
  }

  const std::string& text() const { return text_; }
  const toml::table& document() const { return tables_; }
  std::size_t lines() const { return begins_.size() - 1; }
  /// Where a line (from 1) begins; lines() + 1: the end.
  std::size_t begin_of(std::size_t line) const { return begins_[std::min(line, begins_.size()) - 1]; }
  std::string line(std::size_t number) const {
    return text_.substr(begin_of(number), begin_of(number + 1) - begin_of(number));
  }
  /// The byte at a position of the parser, which counts characters.
  std::size_t place(const toml::source_position& at) const {
    std::size_t byte = begin_of(at.line);
    for (unsigned column = 1; column < at.column && byte < text_.size(); ++column) {
      ++byte;
      while (byte < text_.size() && (static_cast<unsigned char>(text_[byte]) & 0xC0) == 0x80) ++byte;
    }
    return byte;
  }
  [[noreturn]] void refuse(const Sentence& what) const {
    throw Error(Error::Kind::bad_input, say("{}: {}: change it in the text", Name{file_}, what));
  }
  std::string replaced(std::size_t begin, std::size_t end, const std::string& by) const {
    return text_.substr(0, begin) + by + text_.substr(end);
  }
  /// The new text, if it holds these tables.
  std::string checked(const std::string& changed, const toml::table& wanted) const {
    try {
      if (tables::document_of(changed, file_) == wanted) return changed;
    } catch (const Error&) {
      // said below
    }
    refuse("the form cannot make this change");
  }

 private:
  std::string text_, file_;
  toml::table tables_;
  std::vector<std::size_t> begins_;
};

std::optional<std::size_t> index_of(const std::string& step) {
  std::size_t index = 0;
  const auto [end, fault] = std::from_chars(step.data(), step.data() + step.size(), index);
  return fault == std::errc{} && end == step.data() + step.size() ? std::optional(index) : std::nullopt;
}

template <class Node>
Node* child_of(Node& node, const std::string& step) {
  if (auto* table = node.as_table()) return table->get(step);
  const auto index = index_of(step);
  auto* array = node.as_array();
  return array && index && *index < array->size() ? array->get(*index) : nullptr;
}

/// What is at the path; null where nothing is.
template <class Node>
Node* find_node(Node& root, std::span<const std::string> path) {
  Node* node = &root;
  for (const auto& step : path)
    if (node) node = child_of(*node, step);
  return node;
}

toml::table value_table(const Text& text, const std::string& value) {
  try {
    toml::table table = toml::parse(std::string_view("value = " + value));
    if (table.size() == 1) return table;
  } catch (const toml::parse_error&) {
    // said below
  }
  text.refuse(say("'{}' is not a value of TOML", value));
}

std::string key_text(const std::string& key) {
  const bool bare = !key.empty() && std::ranges::all_of(key, [](unsigned char c) {
    return c < 0x80 && (std::isalnum(c) || c == '_' || c == '-');
  });
  return bare ? key : toml_text(key);
}

/// Lines in which tables with a header begin, those inside of `except` apart.
void collect_headers(const toml::node& node, const toml::node* except, std::set<std::size_t>& lines) {
  if (&node == except) return;
  if (const auto* table = node.as_table()) {
    if (table->is_inline()) return;
    for (const auto& [key, child] : *table) {
      if (const auto* inner = child.as_table(); inner && !inner->is_inline() && &child != except)
        lines.insert(inner->source().begin.line);
      collect_headers(child, except, lines);
    }
  } else if (const auto* array = node.as_array()) {
    for (const auto& child : *array) {
      if (const auto* inner = child.as_table(); inner && !inner->is_inline() && &child != except)
        lines.insert(inner->source().begin.line);
      collect_headers(child, except, lines);
    }
  }
}

bool is_blank_or_comment(const std::string& line) {
  const auto first = line.find_first_not_of(" \t\r\n");
  return first == std::string::npos || line[first] == '#';
}

/// The first of the lines of comments that stand right above a header, which is `header` where there are none.
std::size_t with_comments_above(const Text& text, std::size_t header) {
  while (header > 1 && is_blank_or_comment(text.line(header - 1)) && !is_blank(text.line(header - 1))) --header;
  return header;
}

/// The end of a table with a header: behind its last line that is not blank. What stands right above the next header
/// belongs to that.
std::size_t end_of_table(const Text& text, const toml::table& table) {
  std::set<std::size_t> headers;
  collect_headers(text.document(), &table, headers);
  const auto next = headers.upper_bound(table.source().begin.line);
  std::size_t end = next == headers.end() ? text.lines() + 1 : with_comments_above(text, *next);
  while (end > table.source().begin.line + 1 && is_blank(text.line(end - 1))) --end;
  return end;
}

/// The last line of what a table holds itself; 0: nothing.
std::size_t last_line_of(const toml::table& table) {
  std::size_t last = 0;
  for (const auto& [key, node] : table) {
    const auto* inner = node.as_table();
    const auto* array = node.as_array();
    if ((inner && !inner->is_inline()) ||
        (array && array->is_array_of_tables() && !array->empty() && !array->get(0)->as_table()->is_inline()))
      continue;
    last = std::max<std::size_t>(last, node.source().end.line);
  }
  return last;
}

/// "key = value", with the sign of equality below that of the line before.
std::string assignment(const Text& text, std::size_t line_before, const std::string& key, const std::string& value) {
  std::string left = key_text(key);
  if (line_before > 0) {
    const auto before = text.line(line_before);
    const auto equals = before.find(" = ");
    if (!is_blank_or_comment(before) && equals != std::string::npos && before.find_first_of("\"'#{[") > equals)
      left.resize(std::max(left.size(), equals), ' ');
  }
  return left + " = " + value + "\n";
}

std::string inserted_line(const Text& text, const toml::table& table, bool is_root, const std::string& key,
                          const std::string& value) {
  const std::size_t last = last_line_of(table);
  const std::size_t after = last > 0 ? last : is_root ? 0 : table.source().begin.line;
  const std::size_t place = text.begin_of(after + 1);
  const std::string line = assignment(text, last, key, value);
  return text.replaced(place, place, line + (is_root && last == 0 ? "\n" : ""));
}

std::string inserted_inline(const Text& text, const toml::table& table, const std::string& key,
                            const std::string& value) {
  std::size_t end = text.place(table.source().end);
  while (end > 0 && text.text()[end - 1] != '}') --end;
  std::size_t place = end - 1;
  while (place > 0 && text.text()[place - 1] == ' ') --place;
  return text.replaced(place, place, (table.empty() ? "" : ", ") + key_text(key) + " = " + value);
}

/// Before the schedule, with the comments above it; else at the end.
std::string with_new_section(const Text& text, const std::string& name, const std::string& key,
                             const std::string& value) {
  const std::string section = "[" + key_text(name) + "]\n" + key_text(key) + " = " + value + "\n";
  const auto* schedule = text.document()["schedule"].as_array();
  const auto* first = schedule && !schedule->empty() ? schedule->get(0)->as_table() : nullptr;
  if (!first || first->is_inline()) return text.text() + "\n" + section;
  const std::size_t place = text.begin_of(with_comments_above(text, first->source().begin.line));
  return text.replaced(place, place, section + "\n");
}

/// A line "key = value" whole, except for its comment.
std::string without_line(const Text& text, const toml::key& key, const toml::node& node) {
  const std::size_t begin = text.begin_of(key.source().begin.line), next = text.begin_of(node.source().end.line + 1);
  std::size_t end = text.place(node.source().end);
  const std::string before = text.text().substr(begin, text.place(key.source().begin) - begin);
  std::string behind = text.text().substr(end, next - end);
  if (!is_blank(before)) text.refuse("the form cannot make this change");
  if (is_blank(behind)) return text.replaced(begin, next, "");
  return text.replaced(begin, next, before + behind.substr(behind.find_first_not_of(" \t")));
}

std::string without_inline(const Text& text, const toml::key& key, const toml::node& node) {
  std::size_t begin = text.place(key.source().begin), end = text.place(node.source().end);
  const auto& all = text.text();
  const std::size_t behind = all.find_first_not_of(" \t", end);
  if (behind != std::string::npos && all[behind] == ',') {
    end = all.find_first_not_of(" \t", behind + 1);
  } else {
    while (begin > 0 && (all[begin - 1] == ' ' || all[begin - 1] == '\t')) --begin;
    if (begin > 0 && all[begin - 1] == ',') --begin;
  }
  return text.replaced(begin, end, "");
}

/// The lines of one table of a list, from its header on.
struct Lines {
  std::size_t begin, end;  ///< [bytes]
};

const toml::array& list_of(const Text& text, const PlanList& which) {
  const auto* array = text.document()[which.name].as_array();
  if (!array || which.index >= array->size()) text.refuse(say("there is no such [[{}]]", Name{which.name}));
  for (const auto& node : *array)
    if (!node.is_table() || node.as_table()->is_inline())
      text.refuse(say("{} is not written as [[{}]]", Name{which.name}, Name{which.name}));
  return *array;
}

Lines lines_of(const Text& text, const toml::array& array, std::size_t index) {
  const auto& table = *array.get(index)->as_table();
  return {text.begin_of(table.source().begin.line), text.begin_of(end_of_table(text, table))};
}

}  // namespace
}  // namespace plan_edit

using namespace plan_edit;

std::string toml_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + "\"";
}

std::string with_value(const std::string& plan, const std::string& file, const PlanPath& path,
                       const std::string& value) {
  const Text text(plan, file);
  if (path.empty()) text.refuse("the place of the value is missing");
  const toml::table parsed = value_table(text, value);
  toml::table wanted = text.document();
  const auto parents = std::span(path).first(path.size() - 1);
  const auto& key = path.back();
  if (auto* old = find_node<toml::node>(wanted, parents); old && old->is_table())
    old->as_table()->insert_or_assign(key, *parsed.get("value"));
  else if (!old && path.size() == 2)
    wanted.insert(path.front(), toml::table{}), wanted[path.front()].as_table()->insert(key, *parsed.get("value"));
  else
    text.refuse(say("there is no place for {}", fmt::join(path, ".")));
  const auto* parent = find_node<const toml::node>(text.document(), parents);
  if (!parent) return text.checked(with_new_section(text, path.front(), key, value), wanted);
  const auto& table = *parent->as_table();
  if (const auto* node = table.get(key)) {
    if (node->is_table() && !node->as_table()->is_inline()) text.refuse(say("{} is a section", Name{key}));
    return text.checked(text.replaced(text.place(node->source().begin), text.place(node->source().end), value), wanted);
  }
  return text.checked(table.is_inline() ? inserted_inline(text, table, key, value)
                                        : inserted_line(text, table, parents.empty(), key, value),
                      wanted);
}

std::string without_value(const std::string& plan, const std::string& file, const PlanPath& path) {
  const Text text(plan, file);
  if (path.empty()) text.refuse("the place of the value is missing");
  const auto parents = std::span(path).first(path.size() - 1);
  const auto* parent = find_node<const toml::node>(text.document(), parents);
  const auto* table = parent ? parent->as_table() : nullptr;
  const auto found = table ? table->find(path.back()) : toml::const_table_iterator{};
  if (!table || found == table->end()) return plan;
  toml::table wanted = text.document();
  find_node<toml::node>(wanted, parents)->as_table()->erase(path.back());
  return text.checked(table->is_inline() ? without_inline(text, found->first, found->second)
                                         : without_line(text, found->first, found->second),
                      wanted);
}

std::string with_copy(const std::string& plan, const std::string& file, const PlanList& which) {
  const Text text(plan, file);
  const auto& array = list_of(text, which);
  const auto lines = lines_of(text, array, which.index);
  toml::table wanted = text.document();
  auto& list = *wanted[which.name].as_array();
  const toml::table copy = *array.get(which.index)->as_table();
  list.insert(list.cbegin() + static_cast<std::ptrdiff_t>(which.index) + 1, copy);
  const auto block = text.text().substr(lines.begin, lines.end - lines.begin);
  return text.checked(text.replaced(lines.end, lines.end, "\n" + block), wanted);
}

std::string without_table(const std::string& plan, const std::string& file, const PlanList& which) {
  const Text text(plan, file);
  const auto lines = lines_of(text, list_of(text, which), which.index);
  toml::table wanted = text.document();
  auto& list = *wanted[which.name].as_array();
  list.erase(list.cbegin() + static_cast<std::ptrdiff_t>(which.index));
  if (list.empty()) wanted.erase(which.name);
  std::size_t begin = lines.begin, end = lines.end;  // with the blank line between it and the next, or the one before
  if (end < text.text().size() && text.text()[end] == '\n')
    ++end;
  else if (begin >= 2 && text.text().compare(begin - 2, 2, "\n\n") == 0)
    --begin;
  return text.checked(text.replaced(begin, end, ""), wanted);
}

std::string with_next_before(const std::string& plan, const std::string& file, const PlanList& which) {
  const Text text(plan, file);
  const auto& array = list_of(text, which);
  if (which.index + 1 >= array.size()) text.refuse("it is the last one");
  const auto first = lines_of(text, array, which.index), second = lines_of(text, array, which.index + 1);
  toml::table wanted = text.document();
  auto& list = *wanted[which.name].as_array();
  const toml::table moved = *array.get(which.index)->as_table();
  list.erase(list.cbegin() + static_cast<std::ptrdiff_t>(which.index));
  list.insert(list.cbegin() + static_cast<std::ptrdiff_t>(which.index) + 1, moved);
  if (second.begin < first.end) text.refuse("the form cannot make this change");
  const auto part = [&](std::size_t begin, std::size_t end) { return text.text().substr(begin, end - begin); };
  return text.checked(part(0, first.begin) + part(second.begin, second.end) + part(first.end, second.begin) +
                          part(first.begin, first.end) + text.text().substr(second.end),
                      wanted);
}

std::string with_table(const std::string& plan, const std::string& file, const std::string& list,
                       const std::string& lines) {
  const Text text(plan, file);
  toml::table added;
  try {
    added = toml::parse(std::string_view(lines));
  } catch (const toml::parse_error&) {
    text.refuse("the lines of the new table are not TOML");
  }
  const std::string block = "[[" + key_text(list) + "]]\n" + lines + (lines.ends_with('\n') ? "" : "\n");
  toml::table wanted = text.document();
  const auto* array = text.document()[list].as_array();
  if (!array || array->empty()) {
    wanted.insert_or_assign(list, toml::array{added});
    return text.checked(text.text() + (text.text().empty() ? "" : "\n") + block, wanted);
  }
  wanted[list].as_array()->push_back(added);
  const auto last = lines_of(text, list_of(text, {list, array->size() - 1}), array->size() - 1);
  return text.checked(text.replaced(last.end, last.end, "\n" + block), wanted);
}

}  // namespace tumble
