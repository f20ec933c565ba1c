#include "tumble/report/image.hpp"

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/base64.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t largest_image = 1'000'000;

/// The first element of a document of XML is an svg: declarations, comments and blanks may stand before it.
bool is_svg(std::string_view text) {
  if (text.find('\0') != text.npos) return false;
  for (auto at = text.find('<'); at != text.npos; at = text.find('<', at + 1)) {
    const auto rest = text.substr(at);
    if (rest.starts_with("<svg")) return true;
    if (!rest.starts_with("<?") && !rest.starts_with("<!")) return false;
    at = text.find(rest.starts_with("<!--") ? "-->" : ">", at);
    if (at == text.npos) return false;
  }
  return false;
}

const char* kind_of_image(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return "image/png";
  if (bytes.starts_with("\xff\xd8\xff")) return "image/jpeg";
  if (bytes.starts_with("GIF8")) return "image/gif";
  return is_svg(bytes) ? "image/svg+xml" : nullptr;
}

}  // namespace

std::string data_uri_of_image(std::string_view bytes) {
  const char* kind = bytes.size() <= largest_image ? kind_of_image(bytes) : nullptr;
  return kind ? std::string("data:") + kind + ";base64," + base64_of(bytes) : "";
}

std::string data_uri_of_image_file(const std::string& path) {
  auto uri = data_uri_of_image(read_text_file(path));
  if (uri.empty())
    throw Error(Error::Kind::bad_file, path + ": a picture of at most 1 MB is expected: PNG, JPEG, GIF or SVG");
  return uri;
}

}  // namespace tumble
