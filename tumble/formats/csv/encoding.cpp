#include "tumble/formats/csv/encoding.hpp"

#include <iconv.h>

#include <algorithm>
#include <cctype>
#include <cerrno>

#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/file/utf8.hpp"
#include "tumble/units/error.hpp"

namespace tumble::csv {

namespace {

unsigned char byte_at(std::string_view text, std::size_t index) {
  return index < text.size() ? static_cast<unsigned char>(text[index]) : 0;
}

bool control(unsigned value) { return value < 0x20 && value != '\t' && value != '\n' && value != '\r'; }

/// "UTF-16LE", "UTF-16BE" by the zero bytes that digits and separators have; empty: neither.
std::string wide_by_zeros(std::string_view bytes) {
  bytes = bytes.substr(0, 4096);
  std::size_t zeros[2] = {0, 0};
  for (std::size_t i = 0; i < bytes.size(); ++i) zeros[i % 2] += bytes[i] == '\0';
  const std::size_t half = bytes.size() / 2;
  if (half < 2) return "";
  if (zeros[1] * 10 > half * 3 && zeros[0] * 20 < half) return "UTF-16LE";
  if (zeros[0] * 10 > half * 3 && zeros[1] * 20 < half) return "UTF-16BE";
  return "";
}

/// Four bytes of GB 18030, two of which are digits of ASCII: "²" and other characters that GBK does not have.
bool four_bytes(std::string_view bytes, std::size_t at) {
  const auto lead = [&](std::size_t i) { return byte_at(bytes, i) >= 0x81 && byte_at(bytes, i) <= 0xFE; };
  const auto digit = [&](std::size_t i) { return byte_at(bytes, i) >= '0' && byte_at(bytes, i) <= '9'; };
  return lead(at) && digit(at + 1) && lead(at + 2) && digit(at + 3);
}

/// GB 2312 writes a character as two bytes from A1 on: first bytes A1 to A9 are symbols, B0 to D7 the common
/// characters. Western letters with accents are single bytes, the small ones from E0 on.
bool chinese(std::string_view bytes) {
  std::size_t pairs = 0, singles = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const unsigned char first = byte_at(bytes, i), second = byte_at(bytes, i + 1);
    if (first < 0x80) continue;
    const bool common = (first >= 0xA1 && first <= 0xA9) || (first >= 0xB0 && first <= 0xD7);
    if (four_bytes(bytes, i)) {
      ++pairs;
      i += 3;
    } else if (common && second >= 0xA1) {
      ++pairs;
      ++i;
    } else if (first >= 0x81 && first <= 0xFE && second >= 0x80) {
      ++i;  // rare characters, or two accented letters: neither says more
    } else if (i + 1 < bytes.size()) {
      ++singles;
    }
  }
  return pairs > singles;
}

/// The name for iconv of what the user wrote. Throws Error::bad_file.
std::string known_name(const std::string& said, const std::string& path) {
  const std::string name = lower_case(said);
  if (name == "utf-8" || name == "utf8") return "UTF-8";
  if (name == "gbk" || name == "gb2312") return "GB18030";
  if (name == "latin-1" || name == "latin1") return "ISO-8859-1";
  if (name == "utf-16" || name == "utf16") return "UTF-16LE";
  const bool plain = !said.empty() && std::ranges::all_of(said, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_';
  });
  if (plain)
    if (const iconv_t converter = iconv_open("UTF-8", said.c_str()); converter != iconv_t(-1)) {  // NOLINT
      iconv_close(converter);
      return said;
    }
  throw Error{Error::Kind::bad_file, say("'{}': the encoding '{}' is not known; known are for example utf-8, "
                                         "windows-1252, gb18030, utf-16le, utf-16be, shift_jis",
                                         path, said)};
}

Encoding by_bytes(std::string_view beginning) {
  if (beginning.starts_with("\xEF\xBB\xBF")) return {"UTF-8", 3, false, false};
  if (beginning.starts_with("\xFF\xFE")) return {"UTF-16LE", 2, false, false};
  if (beginning.starts_with("\xFE\xFF")) return {"UTF-16BE", 2, false, false};
  if (auto wide = wide_by_zeros(beginning); !wide.empty()) return {wide, 0, true, false};
  if (file::valid_utf8(beginning)) return {};
  return {chinese(beginning) ? "GB18030" : "Windows-1252", 0, true, false};
}

}  // namespace

bool looks_like_text(std::string_view beginning) {
  const Encoding encoding = by_bytes(beginning);
  const bool wide = encoding.name.starts_with("UTF-16"), little = encoding.name == "UTF-16LE";
  if (beginning.size() <= encoding.mark) return false;
  beginning.remove_prefix(encoding.mark);
  for (std::size_t i = 0; i + (wide ? 1 : 0) < beginning.size(); i += wide ? 2 : 1) {
    const unsigned value = !wide ? byte_at(beginning, i)
                                 : byte_at(beginning, i + (little ? 0 : 1)) |
                                       static_cast<unsigned>(byte_at(beginning, i + (little ? 1 : 0))) << 8;
    if (control(value)) return false;
  }
  return true;
}

Encoding encoding_of(std::string_view beginning, const std::string& said, const std::string& path) {
  Encoding encoding = by_bytes(beginning);
  if (!said.empty()) {
    const std::string name = known_name(said, path);
    const bool marked = encoding.mark > 0 && name == encoding.name;
    encoding = {name, marked ? encoding.mark : 0, false, false};
  }
  const bool wide = encoding.name.starts_with("UTF-16") || encoding.name.starts_with("utf-16");
  if (!wide && beginning.find('\n') == std::string_view::npos)
    encoding.return_ends = beginning.find('\r') != std::string_view::npos;
  return encoding;
}

void Decoder::Close::operator()(void* converter) const { iconv_close(converter); }

Decoder::Decoder(const Encoding& encoding)
    : converter_(iconv_open("UTF-8", encoding.name.c_str())),
      step_(lower_case(encoding.name).starts_with("utf-16") ? 2 : 1),
      return_ends_(encoding.return_ends) {
  if (converter_.get() == iconv_t(-1)) {  // NOLINT: iconv's own value for a failure
    static_cast<void>(converter_.release());
    throw Error{Error::Kind::bad_file, say("this system cannot convert text from {} to UTF-8", Name{encoding.name})};
  }
}

void Decoder::append(std::string_view bytes, std::string& text) {
  pending_ += bytes;
  char* in = pending_.data();
  std::size_t left = pending_.size();
  const std::size_t before = text.size();
  char buffer[4096];
  while (left > 0) {
    char* out = buffer;
    std::size_t room = sizeof buffer;
    const std::size_t converted = iconv(converter_.get(), &in, &left, &out, &room);
    text.append(buffer, sizeof buffer - room);
    if (converted != static_cast<std::size_t>(-1) || errno == E2BIG) continue;
    if (errno == EINVAL) break;  // a character that the next bytes complete
    const std::size_t skipped = std::min(step_, left);
    text += "\xEF\xBF\xBD";
    in += skipped;
    left -= skipped;
  }
  pending_.erase(0, pending_.size() - left);
  if (return_ends_) std::replace(text.begin() + static_cast<std::ptrdiff_t>(before), text.end(), '\r', '\n');
}

}  // namespace tumble::csv
