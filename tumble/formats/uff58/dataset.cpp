#include "tumble/formats/uff58/dataset.hpp"

#include <cmath>

#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/file/text_lines.hpp"

namespace tumble::uff58 {

std::string_view field(std::string_view line, std::size_t first, std::size_t count) {
  return first < line.size() ? csv::trimmed(line.substr(first, count)) : std::string_view();
}

bool numbers_in(std::string_view line, std::vector<double>& numbers) {
  numbers.clear();
  std::string token;
  const auto finish = [&] {
    double value = 0.0;
    const bool good = token.empty() || file::number_of(token, '.', value);
    if (!token.empty() && good) numbers.push_back(value);
    token.clear();
    return good;
  };
  for (const char c : line) {
    const bool sign = (c == '-' || c == '+') && !token.empty() && token.back() != 'E';
    if ((c == ' ' || c == '\t' || sign) && !finish()) return false;
    if (c != ' ' && c != '\t') token += c == 'D' || c == 'd' || c == 'e' ? 'E' : c;
  }
  return finish();
}

long whole_number(std::string_view text, long otherwise) {
  double value = 0.0;
  return file::number_of(text, '.', value) && std::abs(value) < 1e9 ? static_cast<long>(value) : otherwise;
}

}  // namespace tumble::uff58
