#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "tumble/wire/codec/content.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble::codec {

/// A character of a line: printed ASCII, a space or a tab.
inline bool is_of_line(unsigned char c) { return (c >= 0x20 && c < 0x7f) || c == '\t'; }

/// [byte] a line has with its end, or up to the byte that cuts it; 0: more bytes are needed; nothing: it is no line of
/// the layout. `bytes` begins with the head.
std::optional<std::size_t> length_of_line(const FrameLayout& layout, std::string_view bytes);

/// A line without its end.
std::string_view without_end(const FrameLayout& layout, std::string_view line);

/// Finds the cells. False where the line has other columns than declared, or is too short.
bool locate_cells(const FrameLayout& layout, std::string_view line, ItemPlaces& places);

/// Whether end, checksum and columns of a line are right; without a checksum also whether its numbers are numbers.
bool sound_line(const FrameLayout& layout, std::string_view line);

/// The bytes between a checksum and what is `after` it; nothing where the line does not have these.
std::optional<std::string_view> summed_range(const FrameChecksum& check, std::string_view line);

/// All bits of the number in a cell, before `shift`; nothing where the cell is not such a number.
std::optional<std::uint64_t> word_in(const FrameNumber& number, std::string_view cell);

/// The value [1] in a cell, before any scale; NaN where the cell is empty or "nan"; nothing where it is not a number.
std::optional<double> value_in(const FrameNumber& number, std::string_view cell);

/// Up to eight letters as one number; of a longer word one that no word has.
std::uint64_t word_bits(std::string_view word);

}  // namespace tumble::codec
