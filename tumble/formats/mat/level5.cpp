// MAT-File Format, The MathWorks: tagged elements, each variable a tree of them, packed by zlib or not.

#include <algorithm>
#include <cstring>
#include <optional>

#include "tumble/formats/file/number_at.hpp"
#include "tumble/formats/file/utf8.hpp"
#include "tumble/formats/mat/array.hpp"
#include "tumble/formats/mat/numbers.hpp"
#include "tumble/formats/mat/packed.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mat {
namespace {

constexpr std::size_t head_size = 128;
constexpr int deepest = 16;                  ///< structures within structures
constexpr std::size_t longest_text = 65536;  ///< [bytes]
constexpr std::size_t usual_packing = 16;    ///< to 1: what packs better is given memory as it comes
constexpr std::size_t most_elements = 4096;  ///< structures of an array of them that are looked at
constexpr std::uint32_t matrix = 14, compressed = 15, utf8 = 16;

enum Class : unsigned char {
  cell = 1,
  structure = 2,
  text = 4,
  sparse = 5,
  first_number = 6,
  last_number = 15,
  opaque = 17
};

struct Tag {
  std::uint32_t type = 0;
  std::size_t size = 0;     ///< [bytes] of the data
  std::size_t padding = 0;  ///< [bytes] behind them
  char small[4] = {};       ///< data of an element of at most four bytes, which stand in the tag
  bool is_small = false;
};

[[noreturn]] void bad(const Sentence& reason) { throw Error(Error::Kind::bad_file, reason); }

class Level5 {
 public:
  Level5(const std::string& path, Contents& contents) : path_(path), contents_(contents), window_(path) {}

  void run() {
    if (!window_.holds(head_size))
      bad(say("'{}' is a MATLAB binary file that is cut off within its first 128 bytes", path_));
    contents_.head = std::string(window_.data(), 116);
    swapped_ = window_.data()[126] == 'M';
    window_.skip(head_size);
    while (window_.holds(8)) {
      const auto type = word(window_.data());
      const std::size_t size = word(window_.data() + 4);
      window_.skip(8);
      const std::size_t begin = window_.position();
      if (type == matrix || type == compressed) variable(size, type == compressed);
      if (contents_.cut_off) return;
      if (window_.position() > begin + size) bad(where("a variable", "it is longer than it says"));
      window_.skip(begin + size - window_.position());
    }
    contents_.cut_off = window_.available() > 0;
  }

 private:
  std::uint32_t word(const char* at) const { return file::number_at<std::uint32_t>(at, swapped_); }

  Sentence where(const Sentence& name, const Sentence& reason) const {
    return say("'{}': {}: {}", path_, name, reason);
  }

  /// One variable; what is whole before a place where the file is cut off is kept.
  void variable(std::size_t size, bool packed) {
    const std::size_t rest = window_.size() - window_.position();
    Bytes bytes(window_, size, packed);
    name_ = say("a variable at byte {}", window_.position());
    try {
      std::size_t end = 0;
      if (packed) {
        const Tag tag = next(bytes);
        if (tag.type != matrix) bad("it does not hold a variable");
        end = bytes.position() + tag.size;
      }
      array(bytes, "", 0);
      if (contents_.keep != Keep::sizes_only) bytes.finish(bytes.position() >= end);
    } catch (const Error& error) {
      if (error.kind != Error::Kind::bad_file) throw;
      if (size <= rest) bad(where(name_, reason_of(error)));
      contents_.cut_off = true;
    }
  }

  Tag next(Bytes& bytes) const {
    char raw[8];
    bytes.read(raw, 8);
    const std::uint32_t first = word(raw);
    Tag tag;
    if ((first >> 16) != 0) {
      tag.type = first & 0xffff;
      tag.size = first >> 16;
      if (tag.size > 4) bad(say("a small element claims {} bytes", tag.size));
      tag.is_small = true;
      std::memcpy(tag.small, raw + 4, 4);
      return tag;
    }
    tag.type = first;
    tag.size = word(raw + 4);
    tag.padding = (8 - tag.size % 8) % 8;
    return tag;
  }

  /// The data of a short element.
  std::string data(Bytes& bytes, const Tag& tag, std::size_t longest) const {
    if (tag.is_small) return {tag.small, tag.size};
    if (tag.size > longest || tag.size > bytes.most()) bad(say("an element claims {} bytes", tag.size));
    std::string result(tag.size, '\0');
    bytes.read(result.data(), tag.size);
    bytes.skip(tag.padding);
    return result;
  }

  std::string data(Bytes& bytes, std::size_t longest) const { return data(bytes, next(bytes), longest); }

  /// The elements behind the tag of a matrix. `given`: the name of a field; a variable brings its own.
  void array(Bytes& bytes, const std::string& given, int depth) {
    if (depth > deepest) bad(say("its structures are nested more than {} deep", deepest));
    const std::string flags = data(bytes, 64);
    if (flags.size() < 8) bad("its flags are missing");
    const auto kind = static_cast<unsigned char>(word(flags.data()) & 0xff);
    if (kind == opaque) {  // datetime, string, table: its name follows without dimensions
      const std::string own = data(bytes, 4096);
      return contents_.leave_out(given.empty() ? std::string(own.c_str()) : given);
    }
    const std::string extent = data(bytes, 1024), own = data(bytes, 4096);
    if (extent.size() < 8) bad("its dimensions are missing");
    const bool complex = (word(flags.data()) & 0x800) != 0;
    const std::string name =
        given.empty() ? std::string(own.data(), own.find('\0') == own.npos ? own.size() : own.find('\0')) : given;
    if (depth == 0) name_ = say("{}", Name{name});
    if (name.empty()) return;  // what MATLAB keeps of its objects
    std::size_t rows = word(extent.data()), columns = word(extent.data() + 4);
    bool flat = true;
    for (std::size_t at = 8; at + 4 <= extent.size(); at += 4) {
      flat = flat && word(extent.data() + at) == 1;
      columns *= std::min<std::size_t>(word(extent.data() + at), std::size_t{1} << 16);
    }
    if (rows == 0 || columns == 0) return;
    if (kind == structure) return fields(bytes, name, rows, columns, depth);
    if (kind == cell) return cells(bytes, name, rows, columns, depth);
    if (kind == text) return characters(bytes, name);
    if (kind >= first_number && kind <= last_number && flat && !complex) return numbers(bytes, name, rows, columns);
    contents_.leave_out(name);
  }

  void numbers(Bytes& bytes, const std::string& name, std::size_t rows, std::size_t columns) {
    const Tag tag = next(bytes);
    const auto type = stored_type(tag.type);
    if (!type) bad(say("its numbers are of the unknown type {}", tag.type));
    const std::size_t size = size_of(*type);
    if (rows > tag.size / size / columns || rows * columns * size != tag.size)
      bad(say("{} x {} numbers do not take {} bytes", rows, columns, tag.size));
    if (!tag.is_small && tag.size > bytes.most()) bad("it is cut off: the file ends within it");
    contents_.budget.take_numbers(rows, columns);
    contents_.numbers += rows * columns;
    if (contents_.keep == Keep::sizes_only) return;  // the caller skips the rest
    Array array(name, std::min(rows, columns), contents_.spool);
    Filler filler(array, rows, columns, std::min(rows * columns, usual_packing * (window_.size() / size)));
    if (tag.is_small) {
      double values[4];
      convert(tag.small, *type, swapped_, rows * columns, values);
      filler.add(values, rows * columns);
    } else {
      fill(bytes, *type, rows * columns, filler);
      bytes.skip(tag.padding);
    }
    contents_.keep_array(std::move(array));
  }

  void fill(Bytes& bytes, Stored type, std::size_t count, Filler& filler) {
    raw_.resize(piece * sizeof(double));
    values_.resize(piece);
    while (count > 0) {
      const std::size_t now = std::min(count, piece);
      if (type == Stored::f64 && !swapped_) {
        bytes.read(reinterpret_cast<char*>(values_.data()), now * sizeof(double));
      } else {
        bytes.read(raw_.data(), now * size_of(type));
        convert(raw_.data(), type, swapped_, now, values_.data());
      }
      filler.add(values_.data(), now);
      count -= now;
    }
  }

  void characters(Bytes& bytes, const std::string& name) {
    const Tag tag = next(bytes);
    const auto type = stored_type(tag.type);
    if (!type || tag.size > longest_text) {
      contents_.leave_out(name);
      if (!tag.is_small) bytes.skip(tag.size + tag.padding);
      return;
    }
    const std::string raw = data(bytes, tag, longest_text);
    if (tag.type == utf8 && file::valid_utf8(raw + ' ')) {
      std::string plain = raw;
      std::ranges::replace_if(
          plain, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
      contents_.keep_text(name, std::move(plain));
      return;
    }
    const std::size_t size = size_of(*type);
    std::vector<double> codes(raw.size() / size);
    convert(raw.data(), *type, swapped_, codes.size(), codes.data());
    contents_.keep_text(name, text_of(codes));
  }

  /// Each a matrix of its own, one behind the other.
  void member(Bytes& bytes, const std::string& name, int depth) {
    const Tag tag = next(bytes);
    if (tag.type != matrix) bad(say("its member {} is no variable", Name{name}));
    if (tag.size == 0) return;
    const std::size_t end = bytes.position() + tag.size;
    array(bytes, name, depth + 1);
    if (bytes.position() > end) bad(say("its member {} is longer than it says", Name{name}));
    bytes.skip(end - bytes.position());
  }

  void fields(Bytes& bytes, const std::string& name, std::size_t rows, std::size_t columns, int depth) {
    const std::string length = data(bytes, 16), all = data(bytes, std::size_t{1} << 20);
    if (length.size() < 4 || word(length.data()) == 0) bad("the names of its fields are missing");
    const std::size_t each = word(length.data()), count = all.size() / each;
    if (rows > most_elements || columns > most_elements || rows * columns > most_elements)
      return contents_.leave_out(name);
    for (std::size_t k = 0; k < rows * columns; ++k)
      for (std::size_t i = 0; i < count; ++i) {
        const std::string field(all.substr(i * each, each).c_str());
        member(bytes, name + (rows * columns > 1 ? "." + std::to_string(k + 1) : "") + "." + field, depth);
      }
  }

  void cells(Bytes& bytes, const std::string& name, std::size_t rows, std::size_t columns, int depth) {
    if (rows > most_elements || columns > most_elements || rows * columns > most_elements)
      return contents_.leave_out(name);
    for (std::size_t k = 0; k < rows * columns; ++k) member(bytes, name + "." + std::to_string(k + 1), depth);
  }

  static constexpr std::size_t piece = 8192;  ///< numbers at a time

  const std::string& path_;
  Contents& contents_;
  file::Window window_;
  bool swapped_ = false;
  Sentence name_;
  std::vector<char> raw_;
  std::vector<double> values_;
};

}  // namespace

Contents read_level5(const std::string& path, Keep keep) {
  Contents contents(path, keep);
  Level5(path, contents).run();
  return contents;
}

}  // namespace tumble::mat
