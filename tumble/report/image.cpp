#include "tumble/report/image.hpp"

#include <fmt/format.h>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/base64.hpp"
#include "tumble/report/image/fault.hpp"
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

struct Kind {
  const char* name;  ///< nothing: another kind of file
  std::string (*fault)(std::string_view);
};

Kind kind_of(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return {"image/png", image::fault_of_png};
  if (bytes.starts_with("\xff\xd8\xff")) return {"image/jpeg", image::fault_of_jpeg};
  if (bytes.starts_with("GIF87a") || bytes.starts_with("GIF89a")) return {"image/gif", image::fault_of_gif};
  if (is_svg(bytes)) return {"image/svg+xml", image::fault_of_svg};
  return {nullptr, [](std::string_view) { return std::string("its first bytes are those of no picture"); }};
}

}  // namespace

std::string fault_of_image(std::string_view bytes) {
  if (bytes.empty()) return "it is empty";
  if (bytes.size() > largest_image) return fmt::format("it has {:.1f} MB", static_cast<double>(bytes.size()) * 1e-6);
  return kind_of(bytes).fault(bytes);
}

std::string data_uri_of_image(std::string_view bytes) {
  const char* kind = kind_of(bytes).name;
  return kind ? std::string("data:") + kind + ";base64," + base64_of(bytes) : "";
}

std::string data_uri_of_image_file(const std::string& path) {
  const std::string bytes = read_text_file(path), fault = fault_of_image(bytes);
  if (!fault.empty())
    throw Error(Error::Kind::bad_file, say("{}: a picture of at most 1 MB is expected, PNG, JPEG, GIF or SVG: {}",
                                           Name{path}, Sentence(fault.c_str())));
  return data_uri_of_image(bytes);
}

}  // namespace tumble
