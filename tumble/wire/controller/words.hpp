#pragma once

#include <optional>
#include <string>

#include "tumble/wire/controller.hpp"

namespace tumble::controller {

/// The word that a whole number means; absent: it has no meaning.
std::optional<std::string> word_of_bits(const ControllerBits& bits, double number);

/// A number that means the word; absent: there is none.
std::optional<double> bits_of_word(const ControllerBits& bits, const std::string& word);

}  // namespace tumble::controller
