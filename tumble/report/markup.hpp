#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tumble {

/// Text for HTML and SVG: control characters removed, & < > " ' as numeric entities. Safe in elements and in quoted
/// attributes.
std::string escaped(std::string_view text);

/// Colours of curves and budget sources, distinguished also by people who see no red or green.
const std::vector<std::string>& palette();
/// The colours of palette() on a dark page.
const std::vector<std::string>& palette_on_dark();

}  // namespace tumble
