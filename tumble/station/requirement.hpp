#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace tumble {

/// A channel's value [SI] or word, as far as it is known.
using ChannelReading = std::variant<std::monostate, double, std::string>;

enum class Holds { no, yes, unknown };

/// Condition on channels, as a station file writes it:
///
///     chamber.temperature < 90 degC
///     input.door == closed and abs(arm.rate) <= 0.1 deg/s
///     unit.status.ok or not input.armed
///
/// A comparison has a channel, or abs(channel), on its left, and a quantity with its unit or a word on its right. A
/// channel alone holds if its word is ok, true, yes, on or 1, or its value is not 0. `and` binds stronger than `or`.
struct Requirement {
  enum class Compare { less, at_most, greater, at_least, equal, unequal, itself };
  struct Term {
    std::string channel;
    bool magnitude = false;
    Compare compare = Compare::itself;
    std::variant<double, std::string> right = 0.0;  ///< [SI] or a word
  };
  struct Step {
    enum class Kind { term, negate, both, either } kind = Kind::term;
    std::size_t term = 0;
  };
  std::string text;  ///< as written
  std::vector<Term> terms;
  std::vector<Step> steps;  ///< the operands of each operator stand before it
};

/// Reads a requirement. A channel that ends in .temperature, .position, .rate, .voltage or .current is compared with a
/// quantity of that kind. Throws Error::bad_input with what would be accepted.
Requirement parse_requirement(std::string_view text);

/// Whether it holds: unknown where that depends on a channel that is not known.
Holds evaluate(const Requirement& requirement,
               const std::function<ChannelReading(const std::string& channel)>& observe);

}  // namespace tumble
