#pragma once

#include <string>
#include <string_view>

namespace tumble {

/// Why a page cannot show a picture, as a sentence about "it": it is truncated, damaged, without a size, larger than 1
/// MB, or no PNG, JPEG, GIF or SVG, which are known by their first bytes. Empty for a sound one.
std::string fault_of_image(std::string_view bytes);

/// "data:image/png;base64,..." of a picture's bytes, so that a page carries it within itself. Empty for bytes of
/// another kind.
std::string data_uri_of_image(std::string_view bytes);

/// data_uri_of_image() of a file. Throws Error::bad_file with the reason: not there, or fault_of_image().
std::string data_uri_of_image_file(const std::string& path);

}  // namespace tumble
