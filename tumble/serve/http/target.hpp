#pragma once

#include <string_view>

#include "tumble/serve/http_server.hpp"

namespace tumble::http {

/// The target of a request, "/a%20b?c=d+e", into path and query, decoded; false where it is not well formed.
bool take_target(std::string_view target, HttpRequest& request);

}  // namespace tumble::http
