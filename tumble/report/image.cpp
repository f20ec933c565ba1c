#include "tumble/report/image.hpp"

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/base64.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t largest_image = 1'000'000;

const char* kind_of_image(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return "image/png";
  if (bytes.starts_with("\xff\xd8\xff")) return "image/jpeg";
  if (bytes.starts_with("GIF8")) return "image/gif";
  const auto text = bytes.substr(0, 1000);
  if (text.find("<svg") != std::string_view::npos && bytes.find('\0') == std::string_view::npos) return "image/svg+xml";
  return nullptr;
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
