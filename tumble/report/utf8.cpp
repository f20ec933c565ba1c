#include "tumble/report/utf8.hpp"

#include <array>

namespace tumble {
namespace {

struct Character {
  char32_t code = 0;
  std::size_t bytes = 1;  ///< consumed
  bool valid = true;
};

/// Decodes the first character; overlong forms, surrogates and codes above U+10FFFF are not valid.
Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  const std::size_t length = lead >= 0xF0 && lead < 0xF8 ? 4 : lead >= 0xE0 ? 3 : lead >= 0xC0 ? 2 : 0;
  if (length == 0 || lead >= 0xF8 || text.size() < length) return {0xFFFD, 1, false};
  char32_t code = lead & (0x7F >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {0xFFFD, 1, false};
    code = (code << 6) | (byte(i) & 0x3F);
  }
  constexpr std::array<char32_t, 5> smallest{0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < smallest[length] || surrogate || code > 0x10FFFF) return {0xFFFD, 1, false};
  return {code, length, true};
}

bool is_control(char32_t code) {
  // C0 and C1 controls, line and paragraph separators, the marks that turn the direction of writing, and the codes that
  // are no characters, which XML and YAML refuse.
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x061C || code == 0x200E || code == 0x200F ||
         (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069) || (code & 0xFFFE) == 0xFFFE;
}

struct Range {
  char32_t first, last;
};

/// Unicode Standard Annex #11, the ranges that are wide as a block.
constexpr std::array<Range, 10> wide{{{0x1100, 0x115F},
                                      {0x2E80, 0xA4CF},
                                      {0xAC00, 0xD7A3},
                                      {0xF900, 0xFAFF},
                                      {0xFE30, 0xFE6F},
                                      {0xFF00, 0xFF60},
                                      {0xFFE0, 0xFFE6},
                                      {0x1F300, 0x1F64F},
                                      {0x1F900, 0x1F9FF},
                                      {0x20000, 0x3FFFD}}};
constexpr std::array<Range, 5> without_width{
    {{0x0300, 0x036F}, {0x1AB0, 0x1AFF}, {0x200B, 0x200F}, {0x20D0, 0x20FF}, {0xFE00, 0xFE0F}}};

/// No line begins with these, and none ends with those.
constexpr std::array<char32_t, 17> closing{U'，', U'。', U'；', U'：', U'？', U'！', U'、', U'）', U'”',
                                           U'’',  U'》', U'～', U',',  U'.',  U';',  U')',  U'%'};
constexpr std::array<char32_t, 5> opening{U'（', U'“', U'‘', U'《', U'('};

template <std::size_t n>
bool among(const std::array<char32_t, n>& characters, char32_t code) {
  for (const char32_t one : characters)
    if (one == code) return true;
  return false;
}

template <std::size_t n>
bool within(const std::array<Range, n>& ranges, char32_t code) {
  for (const auto& range : ranges) {
    if (code >= range.first && code <= range.last) return true;
  }
  return false;
}

}  // namespace

namespace {

/// With `control` for each control character that is not among `kept`.
std::string printable(std::string_view text, std::string_view kept, std::string_view control) {
  std::string result;
  while (!text.empty()) {
    const auto character = first_character(text);
    const bool stays = character.bytes == 1 && kept.find(text.front()) != kept.npos;
    if (!character.valid) {
      result += "\uFFFD";
    } else if (is_control(character.code) && !stays) {
      result += control;
    } else {
      result += text.substr(0, character.bytes);
    }
    text.remove_prefix(character.bytes);
  }
  return result;
}

}  // namespace

std::string printable(std::string_view text) { return printable(text, "", " "); }

std::string printable_lines(std::string_view text) { return printable(text, "\n\t", "\uFFFD"); }

std::vector<std::string> breakable_parts(std::string_view word) {
  std::vector<std::string> parts;
  char32_t before = 0;
  while (!word.empty()) {
    const auto character = first_character(word);
    const bool beside_wide = within(wide, before) || within(wide, character.code);
    if (parts.empty() || (beside_wide && !among(closing, character.code) && !among(opening, before)))
      parts.emplace_back();
    parts.back() += word.substr(0, character.bytes);
    before = character.code;
    word.remove_prefix(character.bytes);
  }
  return parts;
}

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  while (!text.empty()) {
    const auto character = first_character(text);
    width += within(without_width, character.code) ? 0 : within(wide, character.code) ? 2 : 1;
    text.remove_prefix(character.bytes);
  }
  return width;
}

std::string without_middle(std::string_view text, std::size_t columns) {
  std::size_t excess = display_width(text);
  if (excess <= columns) return std::string(text);
  excess -= columns;
  ++excess;  // for the dots
  std::vector<std::string_view> characters;
  for (std::string_view rest = text; !rest.empty(); rest.remove_prefix(characters.back().size()))
    characters.push_back(rest.substr(0, first_character(rest).bytes));
  std::size_t begin = characters.size() / 2, end = begin, removed = 0;
  while (removed < excess && (begin > 0 || end < characters.size())) {
    const bool before = end == characters.size() || (begin > 0 && (end - begin) % 2 == 1);
    removed += display_width(before ? characters[--begin] : characters[end++]);
  }
  std::string result;
  for (std::size_t i = 0; i < begin; ++i) result += characters[i];
  result += "…";
  for (std::size_t i = end; i < characters.size(); ++i) result += characters[i];
  return result;
}

}  // namespace tumble
