#pragma once

#include <optional>
#include <string>

#include "tumble/wire/controller.hpp"

namespace tumble::controller {

/// The word that a whole number [1] means; absent: it has no meaning.
std::optional<std::string> word_of_bits(const ControllerBits& bits, double number);

/// A number [1] that means the word; absent: no number does.
std::optional<double> bits_of_word(const ControllerBits& bits, const std::string& word);

}  // namespace tumble::controller
