#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tumble::csv {

inline const std::string not_read = "-";  ///< in place of the name of a column

/// Cells of one line: quotes removed and blanks around them, quoted separators kept. Blanks as separator collapse.
std::vector<std::string> cells_of(std::string_view line, char separator);

/// The text without the blanks around it and without the end of the line. It points into `text`.
std::string_view trimmed(std::string_view text);

/// In lower case, as far as it is ASCII.
std::string lower_case(std::string_view text);

/// Whether it begins with a number.
bool is_number(const std::string& cell);

/// Whether it reads as a number with either decimal mark, or as a word that instruments write for a missing number.
bool numeric(const std::string& cell);

/// "1,234", "12,345,678.5": digits in groups of three, the first of which is not "0".
/// Given  separator  of the groups; mark  the other one of comma and point, which only digits may follow
bool in_groups(std::string_view cell, char separator, char mark);

/// "nan", "n/a", "--": words for a missing number.
bool reads_like_missing(std::string_view cell);

/// "name[unit]"; the unit may be empty.
struct Named {
  std::string name;
  std::string unit;
};
Named name_and_unit(const std::string& cell);

/// A text for a message: at most `most` bytes, without control characters.
std::string plain_text(std::string_view text, std::size_t most);
/// For a POSIX shell: in single quotes where it has anything but plain characters.
std::string shell_word(const std::string& text);
/// A text for a message in single quotes.
std::string in_quotes(std::string_view text, std::size_t most = 60);

}  // namespace tumble::csv
