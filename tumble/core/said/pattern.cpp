#include "tumble/core/said/pattern.hpp"

#include <algorithm>

namespace tumble::said {

namespace {

bool is_han(std::string_view letter) {
  return letter.size() == 3 && static_cast<unsigned char>(letter[0]) >= 0xe3 &&
         static_cast<unsigned char>(letter[0]) <= 0xe9;
}

std::string_view last_letter(std::string_view text) {
  auto begin = text.size();
  while (begin > 0 && (static_cast<unsigned char>(text[--begin]) & 0xc0) == 0x80) {
  }
  return text.substr(begin);
}

/// Appends what follows. A blank stands between Chinese and Latin letters alone: where a value turned out to be
/// Chinese, it goes.
void append(std::string& text, std::string_view more) {
  const bool ends = text.ends_with(' ') && is_han(last_letter(std::string_view(text).substr(0, text.size() - 1)));
  if (ends && is_han(more.substr(0, 3))) text.pop_back();
  if (more.starts_with(' ') && is_han(more.substr(1, 3)) && is_han(last_letter(text))) more.remove_prefix(1);
  text += more;
}

}  // namespace

Pattern::Pattern(std::string_view english, std::string in_language) : translation(std::move(in_language)) {
  for (std::size_t i = 0; i < english.size(); ++i) {
    const bool doubled = i + 1 < english.size() && english[i + 1] == english[i];
    if (english[i] == '{' && !doubled) {
      const auto name = english.substr(i + 1, english.find_first_of(":}", i) - i - 1);
      i = english.find('}', i);
      if (pieces.size() == 1 || !pieces.back().empty()) names.emplace_back(name);
      if (pieces.size() == 1 || !pieces.back().empty()) pieces.emplace_back();
      continue;
    }
    if (doubled && (english[i] == '{' || english[i] == '}')) ++i;
    pieces.back() += english[i];
    ++letters;
  }
}

std::optional<std::vector<std::string_view>> Pattern::values_in(std::string_view text) const {
  if (pieces.size() == 1 && text != pieces[0]) return std::nullopt;
  if (pieces.size() == 1) return std::vector<std::string_view>();
  const std::string_view first = pieces.front(), last = pieces.back();
  if (text.size() < first.size() + last.size() || !text.starts_with(first) || !text.ends_with(last)) return {};
  text = text.substr(first.size(), text.size() - first.size() - last.size());
  std::vector<std::string_view> values;
  for (std::size_t i = 1; i + 1 < pieces.size(); ++i) {
    const auto found = text.find(pieces[i]);
    if (found == text.npos) return {};
    values.push_back(text.substr(0, found));
    text.remove_prefix(found + pieces[i].size());
  }
  values.push_back(text);
  return values;
}

std::optional<std::string> numbered(const std::string& named, const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < named.size(); ++i) {
    text += named[i];
    if (named[i] != '{') continue;
    const auto name = named.substr(i + 1, named.find_first_of(":}", i) - i - 1);
    const auto found = std::ranges::find(names, name);
    if (name.empty() || found == names.end()) return std::nullopt;
    text += std::to_string(found - names.begin()) + "}";
    i = named.find('}', i);
  }
  return text;
}

std::string filled(std::string_view translation, const std::vector<std::string>& values) {
  std::string text;
  for (std::size_t begin = 0; begin < translation.size();) {
    const auto brace = std::min(translation.find_first_of("{}", begin), translation.size());
    if (brace > begin) append(text, translation.substr(begin, brace - begin));
    if (brace == translation.size()) break;
    const auto end = translation[brace] == '{' ? translation.find('}', brace) : translation.npos;
    const auto number = end == translation.npos ? "" : translation.substr(brace + 1, end - brace - 1);
    if (!number.empty() && number.find_first_not_of("0123456789") == number.npos) {
      const auto index = std::stoul(std::string(number));
      if (index < values.size() && !values[index].empty()) append(text, values[index]);
      begin = end + 1;
    } else {  // a brace that is written twice
      text += translation[brace];
      begin = brace + 2;
    }
  }
  return text;
}

}  // namespace tumble::said
