#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/wire/controller.hpp"

namespace tumble::controller {

enum class Direction { request, reply };

/// Body of a line, between its ends.
struct Line {
  std::optional<std::string> body;
  Sentence problem;               ///< empty: none
  std::uint16_t transaction = 0;  ///< of Modbus over TCP
};

/// Sizes [byte] that a body may have which begins with these bytes, for lines whose end no text marks.
using Sizes = std::function<std::vector<std::size_t>(std::string_view begin)>;

/// The bytes of a body with everything around it. `bare`: nothing is around it.
std::string wrap(const Controller& controller, Direction direction, const std::string& body, bool bare = false,
                 std::uint16_t transaction = 0);

/// The first line of `pending`, which it is removed from; absent until it is complete.
std::optional<Line> take_line(const Controller& controller, Direction direction, const Sizes& sizes,
                              std::string& pending);

/// The text without spaces and ends of lines around it.
std::string stripped(std::string_view text);

}  // namespace tumble::controller
