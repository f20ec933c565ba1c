#include "tumble/formats/file/kinds_of_text.hpp"

#include <algorithm>
#include <cctype>

namespace tumble::file {

namespace {

std::string_view take_line(std::string_view& text) {
  const auto end = text.find('\n');
  auto line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
  return line;
}

}  // namespace

bool is_labview(std::string_view beginning) {
  if (beginning.starts_with("\xEF\xBB\xBF")) beginning.remove_prefix(3);
  return beginning.starts_with("LabVIEW Measurement");
}

bool is_universal(std::string_view beginning) {
  std::string_view line = take_line(beginning);
  while (line.empty() && !beginning.empty()) line = take_line(beginning);
  if (line != "    -1") return false;
  std::string_view number = take_line(beginning);
  const auto first = std::min(number.find_first_not_of(' '), number.size());
  number.remove_prefix(first);
  return first > 0 && !number.empty() && std::isdigit(static_cast<unsigned char>(number.front())) != 0;
}

}  // namespace tumble::file
