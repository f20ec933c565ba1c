#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "tumble/wire/frames.hpp"

namespace tumble::codec {

inline constexpr std::size_t most_items = 128;  ///< of a layout

/// Where an item of a frame is, or a cell of a line. No values of its own: `locate` sets those that a layout has.
struct ItemPlace {
  int at, size;  ///< [byte]; at -1: the frame has no such item
};
using ItemPlaces = std::array<ItemPlace, most_items>;

/// Finds the items of a frame. False where they do not fit into it.
bool locate(const FrameLayout& layout, std::string_view frame, ItemPlaces& places);

/// [byte] of the frame where a number is; nothing where the frame does not hold it.
inline std::optional<std::size_t> place_of(const FrameNumber& number, std::size_t length, const ItemPlaces& places) {
  const int size = static_cast<int>(length);
  if (number.item < 0) {
    const int at = number.at < 0 ? size + number.at : number.at;
    return at < 0 || at + number.bytes > size ? std::nullopt : std::optional(static_cast<std::size_t>(at));
  }
  const ItemPlace& item = places[static_cast<std::size_t>(number.item)];
  if (item.at < 0 || number.at + number.bytes > item.size) return std::nullopt;
  return static_cast<std::size_t>(item.at + number.at);
}

/// How long the frame is that begins with these bytes; 0: more bytes are needed; nothing: no such frame.
std::optional<std::size_t> length_of(const FrameLayout& layout, std::string_view bytes);

/// Whether the first bytes may be those of the layout; `bytes` may be shorter than its sync.
bool begins(const FrameLayout& layout, std::string_view bytes);

/// Whether end, checksums and items of a frame of the right length are right.
bool sound(const FrameLayout& layout, std::string_view frame);

/// Reads a sound frame. `content` has room for the channels of the codec.
void read_content(const FrameCodec& codec, std::size_t frame, std::string_view bytes, FrameContent& content);

}  // namespace tumble::codec
