#include "tumble/wire/controller/template.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "tumble/units/error.hpp"

namespace tumble::controller {

namespace {

using Kind = ControllerPiece::Kind;

bool is_open(const ControllerPiece& piece) {
  return (piece.kind == Kind::any || piece.kind == Kind::word) && piece.format.width == 0;
}

void require_ends(const ControllerTemplate& form) {
  for (std::size_t i = 1; i < form.pieces.size(); ++i) {
    const auto &piece = form.pieces[i], &before = form.pieces[i - 1];
    const bool is_fixed = piece.kind == Kind::literal || piece.format.width > 0 || is_binary(piece);
    const bool number_ends = before.kind == Kind::number &&
                             (before.format.zeros || is_binary(before) || before.part == ControllerPiece::Part::sign);
    const bool runs_on = is_open(before) || (before.kind == Kind::number && !number_ends);
    if (piece.kind != Kind::literal && runs_on && !(before.kind == Kind::number && is_fixed && is_binary(piece)))
      throw Error(Error::Kind::bad_input,
                  say("\"{}\": nothing says where the field '{}' ends; put a fixed text behind it, or a width "
                      "({{name:3s}}, {{name:06.1f}})",
                      form.source, before.text));
  }
}

double value_for(const ControllerPiece& piece, const Content& content) {
  const auto get = [&](const std::string& key) {
    const auto found = content.values.find(key);
    return found == content.values.end() ? std::nullopt : std::optional(found->second);
  };
  auto value = get(key_of(piece));
  if (!value && piece.axis > 0 && content.axis == piece.axis) value = get(piece.text);
  if (!value && piece.otherwise) value = value_of_default(piece);
  if (!value)
    throw Error(Error::Kind::bad_input, say("the value '{}' [{}] is missing", key_of(piece), Name{piece.unit.text()}));
  return *value;
}

std::string word_for(const ControllerPiece& piece, const Content& content) {
  const auto found = content.words.find(piece.text);
  if (found == content.words.end() && !piece.otherwise && piece.kind == Kind::word)
    throw Error(Error::Kind::bad_input, say("the word '{}' is missing", piece.text));
  const std::string text = found == content.words.end() ? piece.otherwise.value_or("") : found->second;
  const int width = piece.format.width;
  if (width > 0 && text.size() != static_cast<std::size_t>(width))
    throw Error(Error::Kind::bad_input, say("{} = '{}' must have {} characters", Name{piece.text}, text, width));
  return text;
}

/// The part of `rest` that an open field takes; absent where the literal behind it is missing.
std::optional<std::string_view> extent(const ControllerTemplate& form, std::size_t i, std::string_view rest) {
  const auto& piece = form.pieces[i];
  if (piece.format.width > 0) {
    const auto width = static_cast<std::size_t>(piece.format.width);
    return rest.size() < width ? std::nullopt : std::optional(rest.substr(0, width));
  }
  if (i + 1 == form.pieces.size()) return rest;
  const std::string& literal = form.pieces[i + 1].text;
  const bool is_last = i + 2 == form.pieces.size();
  const auto end = is_last ? rest.rfind(literal) : rest.find(literal);
  if (end == std::string_view::npos || (is_last && end + literal.size() != rest.size())) return std::nullopt;
  return rest.substr(0, end);
}

/// Values while a template is compared: a sign may stand apart from its magnitude.
struct Comparison {
  Content content;
  std::map<std::string, double> signs;

  bool take(const ControllerTemplate& form, std::size_t i, std::string_view& rest,
            const std::vector<std::string>& axes);
  bool take_axis(std::string_view& rest, const std::vector<std::string>& axes);
};

bool Comparison::take(const ControllerTemplate& form, std::size_t i, std::string_view& rest,
                      const std::vector<std::string>& axes) {
  const auto& piece = form.pieces[i];
  if (piece.kind == Kind::literal) {
    if (!rest.starts_with(piece.text)) return false;
    rest.remove_prefix(piece.text.size());
    return true;
  }
  if (piece.kind == Kind::number) {
    const auto value = take_number(piece, rest);
    if (!value) return false;
    if (piece.part == ControllerPiece::Part::sign)
      signs[key_of(piece)] = *value;
    else
      content.values[key_of(piece)] = *value;
    return true;
  }
  if (piece.kind == Kind::axis) return take_axis(rest, axes);
  const auto text = extent(form, i, rest);
  if (!text || (piece.kind == Kind::word && text->empty())) return false;
  rest.remove_prefix(text->size());
  if (piece.kind == Kind::word) content.words[piece.text] = std::string(*text);
  return true;
}

/// The longest name of an axis that stands there.
bool Comparison::take_axis(std::string_view& rest, const std::vector<std::string>& axes) {
  std::size_t longest = 0;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (axes[i].size() > longest && rest.starts_with(axes[i]))
      longest = axes[i].size(), content.axis = static_cast<int>(i) + 1;
  rest.remove_prefix(longest);
  return longest > 0;
}

}  // namespace

std::string key_of(const ControllerPiece& piece) {
  return piece.axis == 0 ? piece.text : fmt::format("{}.{}", piece.text, piece.axis);
}

std::string latin1(std::string_view utf8) {
  std::string bytes;
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto c = static_cast<unsigned char>(utf8[i]);
    if (c < 0x80) {
      bytes += utf8[i];
    } else if ((c == 0xc2 || c == 0xc3) && i + 1 < utf8.size()) {
      bytes += static_cast<char>((c & 0x03u) << 6 | (static_cast<unsigned char>(utf8[++i]) & 0x3fu));
    } else {
      throw Error(Error::Kind::bad_input,
                  "a character above U+00FF; each character is one byte, which is written \\u00B6 where no key has it");
    }
  }
  return bytes;
}

std::string shown(std::string_view bytes) {
  std::string text;
  for (const char c : bytes.substr(0, 80))
    text += c >= 0x20 && c < 0x7f ? std::string(1, c) : fmt::format("<{:02X}>", static_cast<unsigned char>(c));
  return bytes.size() > 80 ? text + "..." : text;
}

ControllerTemplate parse_template(std::string_view utf8) {
  ControllerTemplate form{std::string(utf8), {}};
  const std::string text = latin1(utf8);
  const auto add_literal = [&](char c) {
    if (form.pieces.empty() || form.pieces.back().kind != Kind::literal) form.pieces.push_back({});
    form.pieces.back().text += c;
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool twice = i + 1 < text.size() && text[i + 1] == text[i];
    if ((text[i] == '{' || text[i] == '}') && twice) {
      add_literal(text[i++]);
    } else if (text[i] == '{') {
      const auto end = text.find('}', i);
      if (end == std::string::npos)
        throw Error(Error::Kind::bad_input, say("\"{}\": a field begins with {{ and has no }}", utf8));
      form.pieces.push_back(parse_field(std::string_view(text).substr(i + 1, end - i - 1)));
      i = end;
    } else if (text[i] == '}') {
      throw Error(Error::Kind::bad_input, say("\"{}\": a }} without {{; a brace itself is }}}}", utf8));
    } else {
      add_literal(text[i]);
    }
  }
  require_ends(form);
  return form;
}

std::string fill(const ControllerTemplate& form, const Content& content, const std::vector<std::string>& axes) {
  std::string bytes;
  for (const auto& piece : form.pieces) {
    if (piece.kind == Kind::literal)
      bytes += piece.text;
    else if (piece.kind == Kind::number)
      bytes += write_number(piece, value_for(piece, content));
    else if (piece.kind == Kind::axis)
      bytes += axes.at(static_cast<std::size_t>(content.axis.value_or(1) - 1));
    else
      bytes += word_for(piece, content);
  }
  return bytes;
}

std::optional<Content> match(const ControllerTemplate& form, std::string_view bytes,
                             const std::vector<std::string>& axes) {
  Comparison comparison;
  for (std::size_t i = 0; i < form.pieces.size(); ++i)
    if (!comparison.take(form, i, bytes, axes)) return std::nullopt;
  if (!bytes.empty()) return std::nullopt;
  for (const auto& [key, sign] : comparison.signs)
    if (const auto value = comparison.content.values.find(key); value != comparison.content.values.end())
      value->second *= sign;
  return comparison.content;
}

std::optional<std::size_t> size_of(const ControllerTemplate& form) {
  std::size_t size = 0;
  for (const auto& piece : form.pieces) {
    const int width = is_binary(piece) ? piece.number.bytes : piece.format.width;
    const bool fixed = is_binary(piece) || (width > 0 && (piece.format.zeros || piece.kind != Kind::number));
    if (piece.kind != Kind::literal && !fixed) return std::nullopt;
    size += piece.kind == Kind::literal ? piece.text.size() : static_cast<std::size_t>(width);
  }
  return size;
}

}  // namespace tumble::controller
