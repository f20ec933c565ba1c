#pragma once

#include <string>
#include <string_view>

namespace tumble {

/// "data:image/png;base64,..." of a picture's bytes, so that a page carries it within itself. PNG, JPEG, GIF and SVG
/// are known by their first bytes. Empty for anything else.
std::string data_uri_of_image(std::string_view bytes);

/// data_uri_of_image() of a file of at most 1 MB. Throws Error::bad_file: not there, too large, another format.
std::string data_uri_of_image_file(const std::string& path);

}  // namespace tumble
