#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/wire/controller/framing.hpp"

namespace tumble::controller {

/// The message around a body. The body of a request is method and target, "GET /api/v1/status"; that of a reply is the
/// status and the text that the message carries, "200 {...}".
std::string http_message(const Controller& controller, Direction direction, const std::string& body);

/// The first message of `pending`, which it is removed from; absent until it is complete.
std::optional<Line> take_http(const Controller& controller, Direction direction, std::string& pending);

/// The values at the JSON pointers of a reply, divided by spaces; without pointers the text itself. Absent where the
/// text is no JSON, or a value is missing.
std::optional<std::string> line_of_json(const std::vector<std::string>& pointers, std::string_view text);

/// A JSON text that has the words of a line at these pointers; the last has the rest of the line.
std::string json_of_line(const std::vector<std::string>& pointers, std::string_view line);

/// Whether the text is a JSON pointer to a value, "/data/result/0".
bool is_json_pointer(const std::string& text);

}  // namespace tumble::controller
