#include "tumble/formats/csv/cells.hpp"

#include <algorithm>
#include <cctype>

#include "tumble/formats/csv/number.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::csv {

namespace {

bool blank(char c) { return c == ' ' || c == '\t'; }

}  // namespace

std::string_view trimmed(std::string_view text) {
  return tumble::trimmed(text.substr(0, text.find_last_not_of(" \t\r") + 1), " \t");
}

std::vector<std::string> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells;
  if (separator == ' ') line = trimmed(line);
  std::string cell;
  bool quoted = false;
  const auto finish = [&] {
    cells.emplace_back(trimmed(cell));
    cell.clear();
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    const bool separates = separator == ' ' ? blank(c) : c == separator;
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cell += line[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (separates && !quoted) {
      finish();
      while (separator == ' ' && i + 1 < line.size() && blank(line[i + 1])) ++i;
    } else {
      cell += c;
    }
  }
  finish();
  return cells;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

bool is_number(const std::string& cell) {
  double value = 0.0;
  return !cell.empty() && fast_float::from_chars(cell.data(), cell.data() + cell.size(), value).ec == std::errc();
}

bool in_groups(std::string_view cell, char separator, char mark) {
  if (cell.starts_with('-') || cell.starts_with('+')) cell.remove_prefix(1);
  const auto digits = [&] {
    std::size_t count = 0;
    while (count < cell.size() && cell[count] >= '0' && cell[count] <= '9') ++count;
    cell.remove_prefix(count);
    return count;
  };
  if (cell.starts_with('0')) return false;
  if (const std::size_t first = digits(); first < 1 || first > 3) return false;
  if (!cell.starts_with(separator)) return false;
  while (cell.starts_with(separator)) {
    cell.remove_prefix(1);
    if (digits() != 3) return false;
  }
  if (cell.starts_with(mark)) {
    cell.remove_prefix(1);
    digits();
  }
  return cell.empty();
}

bool reads_like_missing(std::string_view cell) {
  const auto word = lower_case(cell);
  return std::ranges::any_of(
      std::initializer_list<std::string_view>{"nan", "na", "n/a", "null", "none", "-", "--", "missing"},
      [&](std::string_view known) { return word == known; });
}

bool numeric(const std::string& cell) {
  if (reads_like_missing(cell)) return true;
  const auto word = lower_case(cell);
  for (const char* known : {"inf", "-inf", "+inf", "1.#qnan", "-1.#ind", "1.#inf", "infinity"})
    if (word == known) return true;
  if (word.find_first_of("0123456789") == std::string::npos) return false;
  const auto e = word.find('e');
  if (e == 0) return false;
  return word.find_first_not_of("+-0123456789.,e") == std::string::npos &&
         word.find('e', std::min(e, word.size() - 1) + 1) == std::string::npos &&
         word.find('-', 1) ==
             (e != std::string::npos && e + 1 < word.size() && word[e + 1] == '-' ? e + 1 : std::string::npos);
}

Named name_and_unit(const std::string& cell) {
  const auto open = cell.rfind('[');
  if (open == std::string::npos || !cell.ends_with(']')) return {cell, ""};
  return {std::string(trimmed(std::string_view(cell).substr(0, open))),
          std::string(trimmed(std::string_view(cell).substr(open + 1, cell.size() - open - 2)))};
}

std::string plain_text(std::string_view text, std::size_t most) {
  text = trimmed(text);
  std::string plain(text.substr(0, most));
  while (plain.size() < text.size() && !plain.empty() &&
         (static_cast<unsigned char>(text[plain.size()]) & 0xC0) == 0x80)
    plain.pop_back();  // no part of a character
  for (char& c : plain)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return plain + (text.size() > plain.size() ? "..." : "");
}

std::string shell_word(const std::string& text) {
  const std::string clean = plain_text(text, 4096);
  const bool plain = !clean.empty() && std::ranges::all_of(clean, [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("._-/=+,:@%^").find(static_cast<char>(c)) != std::string_view::npos || c >= 0x80;
  });
  if (plain) return clean;
  std::string word = "'";
  for (const char c : clean) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string in_quotes(std::string_view text, std::size_t most) { return "'" + plain_text(text, most) + "'"; }

}  // namespace tumble::csv
