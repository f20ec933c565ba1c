#include "tumble/wire/codec/content.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/wire/codec/checksum.hpp"
#include "tumble/wire/codec/number.hpp"

namespace tumble::codec {

namespace {

const unsigned char* unsigned_bytes(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

void note_item(const FrameLayout& layout, std::uint64_t id, int at, int size, ItemPlaces& places) {
  for (std::size_t i = 0; i < layout.items.size(); ++i)
    if (layout.items[i].id == id && places[i].at < 0 && size >= layout.items[i].size) places[i] = {at, size};
}

bool locate_list(const FrameLayout& layout, std::string_view frame, ItemPlaces& places) {
  const FrameItemList& list = *layout.list;
  const int length = static_cast<int>(frame.size());
  const int end = place_in(length, list.to, true), head = list.id_bytes + list.size_bytes;
  int at = list.from;
  while (at + head <= end) {
    const unsigned char* const from = unsigned_bytes(frame) + at;
    const auto id = word_of(from + (list.size_first ? list.size_bytes : 0), list.id_bytes, list.big);
    const auto stated = word_of(from + (list.size_first ? 0 : list.id_bytes), list.size_bytes, list.big);
    if (stated > static_cast<std::uint64_t>(length)) return false;
    const int size = static_cast<int>(stated) - (list.size_counts_head ? head : 0);
    if (size < 0 || at + head + size > end) return false;
    note_item(layout, id, at + head, size, places);
    at += head + size;
  }
  return at == end;
}

bool locate_masked(const FrameLayout& layout, std::string_view frame, ItemPlaces& places) {
  int at = layout.masks_from;
  for (std::size_t m = 0; m < layout.masks.size(); ++m) {
    const FrameMask& mask = layout.masks[m];
    const auto bits = natural_of(mask.number, unsigned_bytes(frame) + mask.number.at);
    for (std::size_t bit = 0; bit < mask.sizes.size(); ++bit)
      if (bits >> bit & 1u) {
        note_item(layout, 64 * m + bit, at, mask.sizes[bit], places);
        at += mask.sizes[bit];
      }
  }
  return at + layout.masks_tail == static_cast<int>(frame.size());
}

bool is_met(const FrameCondition& condition, std::string_view frame, std::size_t at) {
  const auto value = natural_of(condition.number, unsigned_bytes(frame) + at);
  return (condition.modulus ? value % condition.modulus : value) == condition.equals;
}

void read_fields(const FrameLayout& layout, std::string_view frame, const ItemPlaces& places, FrameContent& content) {
  for (const FrameField& field : layout.fields) {
    const auto at = place_of(field.number, frame.size(), places);
    if (!at) continue;
    if (field.when) {
      const auto of = place_of(field.when->number, frame.size(), places);
      if (!of || !is_met(*field.when, frame, *of)) continue;
    }
    const double value = value_of(field.number, unsigned_bytes(frame) + *at) * field.factor + field.zero;
    content.values[field.channel] = std::isfinite(value) ? value : std::nan("");
    content.present[field.channel] = 1;
  }
  content.not_good = 0;
  for (std::size_t i = 0; i < layout.statuses.size(); ++i) {
    const FrameStatus& status = layout.statuses[i];
    const auto at = place_of(status.good.number, frame.size(), places);
    if (!at || is_met(status.good, frame, *at)) continue;
    content.not_good |= std::uint64_t{1} << i;
    if (!status.fails) continue;
    for (const std::size_t channel : status.channels) content.values[channel] = std::nan("");
  }
}

/// The time of the first choice whose parts the frame has.
void read_time_of(const FrameLayout& layout, std::string_view frame, const ItemPlaces& places, FrameContent& content) {
  content.time.reset();
  for (std::size_t i = 0; i < layout.time.size();) {
    const int choice = layout.time[i].choice;
    double sum = 0.0, wrap = 0.0;
    bool whole = true;
    for (; i < layout.time.size() && layout.time[i].choice == choice; ++i) {
      const auto at = place_of(layout.time[i].number, frame.size(), places);
      whole = whole && at;
      if (at) sum += value_of(layout.time[i].number, unsigned_bytes(frame) + *at) * layout.time[i].factor;
      wrap = std::max(wrap, layout.time[i].wrap);
    }
    if (!whole || !(std::abs(sum) < 1e12)) continue;  // no clock counts longer
    content.time = sum;
    content.wrap = wrap;
    return;
  }
}

}  // namespace

bool locate(const FrameLayout& layout, std::string_view frame, ItemPlaces& places) {
  std::fill_n(places.begin(), layout.items.size(), ItemPlace{});
  if (layout.list) return locate_list(layout, frame, places);
  return layout.masks.empty() || locate_masked(layout, frame, places);
}

std::optional<std::size_t> place_of(const FrameNumber& number, std::size_t length, const ItemPlaces& places) {
  const int size = static_cast<int>(length);
  if (number.item < 0) {
    const int at = number.at < 0 ? size + number.at : number.at;
    return at < 0 || at + number.bytes > size ? std::nullopt : std::optional(static_cast<std::size_t>(at));
  }
  const ItemPlace& item = places[static_cast<std::size_t>(number.item)];
  if (item.at < 0 || number.at + number.bytes > item.size) return std::nullopt;
  return static_cast<std::size_t>(item.at + number.at);
}

std::optional<std::size_t> length_of(const FrameLayout& layout, std::string_view bytes) {
  const auto has = [&](const FrameNumber& number) {
    return bytes.size() >= static_cast<std::size_t>(number.at + number.bytes);
  };
  std::uint64_t length = static_cast<std::uint64_t>(layout.length);
  if (layout.length_number) {
    if (!has(*layout.length_number)) return 0;
    const auto stated = natural_of(*layout.length_number, unsigned_bytes(bytes) + layout.length_number->at);
    if (stated > static_cast<std::uint64_t>(layout.longest)) return std::nullopt;
    const auto total = static_cast<std::int64_t>(stated) + layout.length_add;
    if (total < layout.length) return std::nullopt;
    length = static_cast<std::uint64_t>(total);
  }
  if (!layout.masks.empty()) length = static_cast<std::uint64_t>(layout.masks_from + layout.masks_tail);
  for (const FrameMask& mask : layout.masks) {
    if (!has(mask.number)) return 0;
    const auto bits = natural_of(mask.number, unsigned_bytes(bytes) + mask.number.at);
    if (bits >> mask.sizes.size()) return std::nullopt;
    for (std::size_t bit = 0; bit < mask.sizes.size(); ++bit)
      if (bits >> bit & 1u) length += static_cast<std::uint64_t>(mask.sizes[bit]);
  }
  const bool fixed = !layout.length_number && layout.masks.empty();
  if (!fixed && length > static_cast<std::uint64_t>(layout.longest)) return std::nullopt;
  return static_cast<std::size_t>(length);
}

bool begins(const FrameLayout& layout, std::string_view bytes) {
  const std::size_t count = std::min(bytes.size(), layout.sync.size());
  for (std::size_t i = 0; i < count; ++i)
    if ((bytes[i] ^ layout.sync[i]) & layout.sync_mask[i]) return false;
  return true;
}

bool sound(const FrameLayout& layout, std::string_view frame) {
  if (!frame.ends_with(layout.end)) return false;
  for (const FrameChecksum& check : layout.checks)
    if (!has_room(check, frame.size()) || !holds(check, frame)) return false;
  if (!layout.list && layout.masks.empty()) return true;
  ItemPlaces places;
  return locate(layout, frame, places);
}

void read_content(const FrameCodec& codec, std::size_t frame, std::string_view bytes, FrameContent& content) {
  const FrameLayout& layout = codec.frames[frame];
  content.frame = frame;
  std::ranges::fill(content.values, std::nan(""));
  std::ranges::fill(content.present, static_cast<unsigned char>(0));
  ItemPlaces places;
  locate(layout, bytes, places);
  read_fields(layout, bytes, places, content);
  content.counter.reset();
  if (layout.counter)
    if (const auto at = place_of(layout.counter->number, bytes.size(), places))
      content.counter = natural_of(layout.counter->number, unsigned_bytes(bytes) + *at) % layout.counter->modulus;
  read_time_of(layout, bytes, places, content);
}

}  // namespace tumble::codec

namespace tumble {

std::optional<FrameContent> decode_frame(const FrameCodec& codec, std::string_view bytes) {
  for (std::size_t frame = 0; frame < codec.frames.size(); ++frame) {
    const FrameLayout& layout = codec.frames[frame];
    if (bytes.size() < layout.sync.size() || !codec::begins(layout, bytes)) continue;
    const auto length = codec::length_of(layout, bytes);
    if (!length || *length != bytes.size() || !codec::sound(layout, bytes)) continue;
    FrameContent content;
    content.values.resize(codec.channels.size());
    content.present.resize(codec.channels.size());
    codec::read_content(codec, frame, bytes, content);
    return content;
  }
  return std::nullopt;
}

}  // namespace tumble
