#pragma once

#include <string>
#include <string_view>

namespace tumble::image {

// Why a picture cannot be shown, as a sentence about "it": it ends early, its bytes were changed, it has no size. Empty
// for a sound one. Each is given bytes that begin as its format does. Of pictures made of points the frame is read, in
// which lengths and, in PNG, checksums show what is missing; the points are not decoded.

std::string fault_of_png(std::string_view picture);
std::string fault_of_jpeg(std::string_view picture);
std::string fault_of_gif(std::string_view picture);
std::string fault_of_svg(std::string_view picture);

}  // namespace tumble::image
