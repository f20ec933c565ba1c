#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/units/factor.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

/// Meaning of one word of a unit: "deg", "ug", "degC". `offset` is only for a temperature that stands alone.
struct Meaning {
  Dimension dimension;
  Factor factor;
  double offset = 0.0;
};

/// A whole word of the table comes first (`min` is minute, `kg` kilogram, `mol` nothing), then an SI prefix before a
/// word that takes it (`mm`, `mrad`, `mg` = g/1000: the field's milli-gravity; grams are not known).
std::optional<Meaning> meaning_of(std::string_view word);

/// A word of the table and the SI prefixes that it takes, a letter each: "u" is micro.
struct UnitWord {
  std::string_view text, prefixes;
};
/// All words of units: lengths, times, angles and so on, in the order of the table.
std::vector<UnitWord> unit_words();

/// Advice on a word that meaning_of() does not know: "; did you mean 'deg'?", or why it is refused.
Sentence advice_on(std::string_view word);

}  // namespace tumble
