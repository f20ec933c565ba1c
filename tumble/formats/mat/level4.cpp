// Version 4: each variable a head of five integers, a name, and numbers column by column.

#include <algorithm>

#include "tumble/formats/file/number_at.hpp"
#include "tumble/formats/file/window.hpp"
#include "tumble/formats/mat/array.hpp"
#include "tumble/formats/mat/numbers.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mat {
namespace {

constexpr std::size_t variable_head = 20;
constexpr std::size_t longest_name = 256;
constexpr std::size_t piece_of_level4 = 8192;  ///< numbers at a time

/// The head of a variable.
struct Head {
  bool swapped = false;
  Stored type = Stored::f64;
  int kind = 0;  ///< 0 numbers, 1 text, 2 sparse
  std::uint32_t rows = 0, columns = 0;
  bool complex = false;
  std::uint32_t name = 0;  ///< [bytes] with the zero at its end
};

/// Nothing where the bytes are no head.
std::optional<Head> head_at(const char* at) {
  Head head;
  head.swapped = file::number_at<std::uint32_t>(at) > 9999;
  std::uint32_t words[5];
  for (std::size_t i = 0; i < 5; ++i) words[i] = file::number_at<std::uint32_t>(at + 4 * i, head.swapped);
  const std::uint32_t order = words[0] / 1000, unused = words[0] / 100 % 10, precision = words[0] / 10 % 10;
  static constexpr Stored types[] = {Stored::f64, Stored::f32, Stored::i32, Stored::i16, Stored::u16, Stored::u8};
  if (order != (head.swapped ? 1u : 0u) || unused != 0 || precision > 5 || words[0] % 10 > 2 || words[3] > 1 ||
      words[4] < 2 || words[4] > longest_name)
    return std::nullopt;
  head.type = types[precision];
  head.kind = static_cast<int>(words[0] % 10);
  head.rows = words[1];
  head.columns = words[2];
  head.complex = words[3] == 1;
  head.name = words[4];
  return head;
}

bool is_name(const char* at, std::size_t size) {
  return at[size - 1] == '\0' && std::all_of(at, at + size - 1, [](unsigned char c) {
           return c == '_' || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
         });
}

void take_numbers(file::Window& window, const Head& head, const std::string& name, Contents& contents) {
  const std::size_t size = size_of(head.type);
  Array array(name, head.kind == 0 ? std::min(head.rows, head.columns) : 0, contents.spool);
  std::vector<double> values(piece_of_level4), codes;
  Filler filler(array, head.rows, head.columns, std::size_t{head.rows} * head.columns);
  for (std::size_t left = std::size_t{head.rows} * head.columns; left > 0;) {
    const std::size_t now = std::min(left, piece_of_level4);
    if (!window.holds(now * size)) {
      contents.cut_off = true;
      return;
    }
    convert(window.data(), head.type, head.swapped, now, values.data());
    window.skip(now * size);
    if (head.kind == 0) filler.add(values.data(), now);
    if (head.kind == 1) codes.insert(codes.end(), values.begin(), values.begin() + static_cast<std::ptrdiff_t>(now));
    left -= now;
  }
  if (head.kind == 0 && !array.vectors.empty()) contents.keep_array(std::move(array));
  if (head.kind == 1) contents.keep_text(name, text_of(codes));
}

}  // namespace

bool is_level4(const std::string& path) {
  file::Window window(path);
  if (!window.holds(variable_head + 2)) return false;
  const auto head = head_at(window.data());
  return head && window.holds(variable_head + head->name) && is_name(window.data() + variable_head, head->name) &&
         std::uint64_t{head->rows} * head->columns * size_of(head->type) <= 8 * window.size() + 64;
}

Contents read_level4(const std::string& path, Keep keep) {
  Contents contents(path, keep);
  contents.head = "MATLAB 4";
  file::Window window(path);
  while (window.holds(variable_head)) {
    const auto head = head_at(window.data());
    if (!head)
      throw Error(Error::Kind::bad_file, say("'{}': no variable of a MATLAB file of version 4 begins at byte {}", path,
                                             Name{std::to_string(window.position())}));
    window.skip(variable_head);
    if (!window.holds(head->name)) break;
    const std::string name(window.data(), std::find(window.data(), window.data() + head->name, '\0'));
    window.skip(head->name);
    const std::uint64_t count = std::uint64_t{head->rows} * head->columns, parts = head->complex ? 2 : 1;
    if (count > (window.size() - window.position()) / size_of(head->type) / parts) {
      contents.cut_off = true;
      return contents;
    }
    if (head->kind == 2 || head->complex) {
      contents.leave_out(name);
      window.skip(count * size_of(head->type) * parts);
      continue;
    }
    contents.budget.take_numbers(head->rows, head->columns);
    contents.numbers += count;
    if (keep == Keep::sizes_only) {
      window.skip(count * size_of(head->type));
      continue;
    }
    take_numbers(window, *head, name, contents);
  }
  contents.cut_off = contents.cut_off || window.available() > 0;
  return contents;
}

}  // namespace tumble::mat
