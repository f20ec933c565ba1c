#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "tumble/station/executive.hpp"

namespace tumble {

/// Meaning of a line that a person types while a run goes on: "abort" always ends it, a choice of the open question
/// answers it (an empty line chooses the standard one), "p" pauses, "r" resumes.
///
/// Given     line  without its end
///           open  the question that is open, if there is one
///           who   types it
///
/// Returned  the order or answer; nothing where the line means nothing: then the question stays open
std::optional<decltype(RunEvent::what)> order_of_line(const std::string& line, const std::optional<Prompt>& open,
                                                      const std::string& who);

/// The word of an order that the desk of a run takes: "pause" is at the next segment. Empty: the desk does not take it.
std::string_view desk_word(RunOrder::Kind kind);

/// The order with this word at the desk; absent: no order has it.
std::optional<RunOrder::Kind> find_order(std::string_view desk_word);

}  // namespace tumble
