#pragma once

#include <toml++/toml.h>

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/tables/section.hpp"
#include "tumble/wire/declaration/scale.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble::declaration {

/// A declaration while it is read.
struct Draft {
  FrameCodec codec;
  tables::Problems problems;
  Scales scales;
  bool big = false;  ///< where nothing else says the order of bytes
};

/// Bytes from "FE 81 FF 55"; with `mask` a '.' is a digit that may be any. Throws Error::bad_input.
std::string parse_hex(std::string_view text, std::string* mask = nullptr);

/// A whole number with a sign; absent with a problem where the key holds something else.
std::optional<long long> whole_of(tables::Section& section, std::string_view key);

/// "big" or "little", else what holds around.
bool order_of(tables::Section& section, bool around);

/// The tables at `key`: one, or a list of them.
std::vector<const toml::table*> tables_at(tables::Section& section, std::string_view key);

/// One number from the keys at, type, bits and order; `type` where that key is absent.
FrameNumber number_of(tables::Section& section, bool big, std::string_view type);

/// The items that a number stands in, from the keys id or bit: indices into layout.items, -1 for the frame itself.
std::vector<int> items_of(tables::Section& section, FrameLayout& layout);

/// Sees to it that the number lies in its item or in the frame.
void place_number(tables::Section& section, const FrameNumber& number, FrameLayout& layout);

void read_checks(tables::Section& section, bool big, FrameLayout& layout, Draft& draft);
void read_channels(tables::Section& section, bool big, FrameLayout& layout, Draft& draft);
void read_statuses(tables::Section& section, bool big, FrameLayout& layout, Draft& draft);
void read_counter(tables::Section& section, bool big, FrameLayout& layout, Draft& draft);
void read_time(tables::Section& section, bool big, FrameLayout& layout, Draft& draft);
void read_layout(const toml::table& table, Draft& draft);

}  // namespace tumble::declaration
