#pragma once

#include <toml++/toml.h>

#include <optional>
#include <string_view>
#include <vector>

#include "tumble/core/tables/section.hpp"
#include "tumble/wire/declaration/draft.hpp"
#include "tumble/wire/declaration/scale.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble::declaration {

/// A declaration of frames while it is read.
struct Declared {
  Draft draft;
  FrameCodec codec;
  Scales scales;
  bool big = false;  ///< where nothing else says the order of bytes
};

/// A whole number with a sign; absent with a problem where the key holds something else.
std::optional<long long> whole_of(tables::Section& section, std::string_view key);

/// "big" or "little", else what holds around.
bool order_of(tables::Section& section, bool around);

/// One number from the keys at, type, bits and order, of a line type, bits and digits; `type` where that key is absent.
FrameNumber number_of(tables::Section& section, bool big, std::string_view type, const FrameLayout& layout);

/// The cell of a line from the keys column, or at and width; `offset` columns or bytes further. Index of its item.
int cell_of(tables::Section& section, FrameLayout& layout, int offset);

/// Whether the frame is a line of text; then its head, end and delimiter.
bool read_line(tables::Section& section, FrameLayout& layout);
/// The columns, once all cells are known.
void close_line(tables::Section& section, FrameLayout& layout);

/// The items that a number stands in, from the keys id or bit: indices into layout.items, -1 for the frame itself. Of a
/// line its cell.
std::vector<int> items_of(tables::Section& section, FrameLayout& layout);

/// Sees to it that the number lies in its item or in the frame.
void place_number(tables::Section& section, const FrameNumber& number, FrameLayout& layout);

void read_checks(tables::Section& section, bool big, FrameLayout& layout, Declared& declared);
void read_channels(tables::Section& section, bool big, FrameLayout& layout, Declared& declared);
void read_statuses(tables::Section& section, bool big, FrameLayout& layout, Declared& declared);
void read_counter(tables::Section& section, bool big, FrameLayout& layout, Declared& declared);
void read_time(tables::Section& section, bool big, FrameLayout& layout, Declared& declared);
void read_layout(const toml::table& table, Declared& declared);

}  // namespace tumble::declaration
