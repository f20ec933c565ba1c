#include "tumble/formats/uff58/binary.hpp"

#include <algorithm>
#include <sstream>

#include "tumble/formats/csv/encoding.hpp"
#include "tumble/formats/file/number_at.hpp"
#include "tumble/formats/file/window.hpp"
#include "tumble/units/error.hpp"

namespace tumble::uff58 {

namespace {

constexpr std::size_t longest_line = 4096, piece_size = std::size_t{48} * 8192;  // [bytes]

std::string in_utf8(std::string_view line, const std::string& path) {
  while (line.ends_with('\r')) line.remove_suffix(1);
  const csv::Encoding encoding = csv::encoding_of(line, "", path);
  std::string text;
  if (encoding.plain())
    text = line;
  else
    csv::Decoder(encoding).append(line, text);
  return text;
}

}  // namespace

BinaryHead binary_head(std::string_view line) {
  std::istringstream words{std::string(line)};
  std::string name;
  long order = 0, format = 0, lines = 0, bytes = -1;
  words >> name >> order >> format >> lines >> bytes;
  if (words.fail() || (order != 1 && order != 2) || lines != 11 || bytes < 0)
    throw Error{Error::Kind::bad_file,
                "the first line of a binary dataset (58b) must have the order of bytes (1 or 2), the format of the "
                "numbers, 11 lines and the number of bytes"};
  if (format != 2)
    throw Error{Error::Kind::bad_file, say("a binary dataset 58 (58b) with numbers of format {}; those of IEEE 754 "
                                           "(format 2) are read: export it as ASCII",
                                           Name{std::to_string(format)})};
  return {order == 2, static_cast<std::size_t>(bytes)};
}

BinaryNumbers binary_numbers(const BinaryHead& head, bool double_precision, bool even, std::size_t count) {
  const std::size_t size = double_precision ? 8 : 4;
  if (head.bytes / size == (even ? 1 : 2) * count && head.bytes % size == 0) return {size, false};
  if (double_precision && !even && head.bytes / 12 == count && head.bytes % 12 == 0) return {size, true};
  return {};
}

void decode_binary(std::string_view bytes, const BinaryNumbers& kind, bool reversed, std::vector<double>& numbers) {
  numbers.clear();
  for (const char* at = bytes.data(); at < bytes.data() + bytes.size();) {
    if (kind.size == 4 || kind.mixed) numbers.push_back(file::number_at<float>(at, reversed)), at += 4;
    if (kind.size == 8) numbers.push_back(file::number_at<double>(at, reversed)), at += 8;
  }
}

void each_part(const std::string& path, const Progress& progress, const Parts& parts) {
  file::Window window(path);
  for (std::size_t number = 1; window.holds(1); ++number) {
    report(progress, static_cast<double>(window.position()) / static_cast<double>(window.size() + 1), "reading");
    window.holds(longest_line);
    const std::string_view here(window.data(), std::min(window.available(), longest_line));
    const auto end = here.find('\n');
    if (end == here.npos && here.size() == longest_line)
      throw Error{Error::Kind::bad_file,
                  say("'{}', line {}: more than {} characters", path, number, Name{std::to_string(longest_line)})};
    const std::string line = in_utf8(here.substr(0, end), path);
    window.skip(end == here.npos ? here.size() : end + 1);
    parts.line(line, number);
    for (std::size_t due = parts.bytes_due(); due > 0 && window.holds(1);) {
      const std::size_t now = std::min(due, piece_size);
      const bool whole = window.holds(now);
      const std::size_t count = whole ? now : window.available();
      if (whole) parts.bytes({window.data(), count});
      window.skip(count);
      due -= now;
      if (!whole) return;  // cut off
    }
  }
}

bool has_binary_datasets(const std::string& path) {
  constexpr std::string_view begin = "\n    58b";
  file::Window window(path);
  while (window.holds(begin.size())) {
    const std::string_view here(window.data(), window.available());
    if (here.find(begin) != here.npos) return true;
    window.skip(here.size() - begin.size() + 1);
  }
  return false;
}

}  // namespace tumble::uff58
