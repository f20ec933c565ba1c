#pragma once

#include <string_view>

namespace tumble::certificate {

/// Whether two letters are a country code of ISO 3166-1.
bool is_country(std::string_view code);

}  // namespace tumble::certificate
