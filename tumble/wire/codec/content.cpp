#include "tumble/wire/codec/content.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/wire/codec/checksum.hpp"
#include "tumble/wire/codec/line.hpp"
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

/// A frame whose items are found.
struct LocatedFrame {
  std::string_view bytes;
  const ItemPlaces& places;

  /// The characters of a number of a line; nothing where the line does not have its cell.
  std::optional<std::string_view> cell(const FrameNumber& number) const {
    const ItemPlace& cell = places[static_cast<std::size_t>(number.item)];
    if (cell.at < 0) return std::nullopt;
    return bytes.substr(static_cast<std::size_t>(cell.at), static_cast<std::size_t>(cell.size));
  }

  /// The value [1] of a number, before any scale; nothing where the frame does not hold it.
  std::optional<double> value(const FrameNumber& number, int& unreadable) const {
    if (number.form != FrameNumber::Form::binary) return value_of_cell(number, unreadable);
    const auto at = place_of(number, bytes.size(), places);
    if (!at) return std::nullopt;
    return value_of(number, unsigned_bytes(bytes) + *at);
  }

  std::optional<double> value_of_cell(const FrameNumber& number, int& unreadable) const {
    const auto text = cell(number);
    if (!text) return std::nullopt;
    const auto value = value_in(number, *text);
    if (!value) ++unreadable;
    return value.value_or(std::nan(""));
  }

  /// Its bits as a natural number; of a cell that is not a number one that no number has.
  std::optional<std::uint64_t> natural(const FrameNumber& number) const {
    if (number.form != FrameNumber::Form::binary) {
      const auto text = cell(number);
      if (!text) return std::nullopt;
      const auto word = word_in(number, *text);
      return word ? *word >> number.shift & mask_of(number.bits) : no_natural;
    }
    const auto at = place_of(number, bytes.size(), places);
    if (!at) return std::nullopt;
    return natural_of(number, unsigned_bytes(bytes) + *at);
  }

  static constexpr std::uint64_t no_natural = ~std::uint64_t{0};
};

/// Whether the condition holds; nothing where the frame does not hold its number.
std::optional<bool> is_met(const FrameCondition& condition, const LocatedFrame& frame) {
  const auto value = frame.natural(condition.number);
  if (!value) return std::nullopt;
  return (condition.modulus ? *value % condition.modulus : *value) == condition.equals;
}

void read_fields(const FrameLayout& layout, const LocatedFrame& frame, FrameContent& content) {
  for (const FrameField& field : layout.fields) {
    if (field.when && !is_met(*field.when, frame).value_or(false)) continue;
    const auto raw = frame.value(field.number, content.unreadable);
    if (!raw) continue;
    const double value = *raw * field.factor + field.zero;
    content.values[field.channel] = std::isfinite(value) ? value : std::nan("");
    content.present[field.channel] = 1;
  }
  content.not_good = 0;
  for (std::size_t i = 0; i < layout.statuses.size(); ++i) {
    const FrameStatus& status = layout.statuses[i];
    if (is_met(status.good, frame).value_or(true)) continue;
    content.not_good |= std::uint64_t{1} << i;
    if (!status.fails) continue;
    for (const std::size_t channel : status.channels) content.values[channel] = std::nan("");
  }
}

void read_counter_of(const FrameLayout& layout, const LocatedFrame& frame, FrameContent& content) {
  content.counter.reset();
  if (!layout.counter) return;
  const auto counter = frame.natural(layout.counter->number);
  if (!counter) return;
  if (layout.text && *counter == LocatedFrame::no_natural)
    ++content.unreadable;
  else
    content.counter = *counter % layout.counter->modulus;
}

/// The time of the first choice whose parts the frame has.
void read_time_of(const FrameLayout& layout, const LocatedFrame& frame, FrameContent& content) {
  content.time.reset();
  for (std::size_t i = 0; i < layout.time.size();) {
    const int choice = layout.time[i].choice;
    double sum = 0.0, wrap = 0.0;
    bool whole = true;
    for (; i < layout.time.size() && layout.time[i].choice == choice; ++i) {
      const auto value = frame.value(layout.time[i].number, content.unreadable);
      whole = whole && value;
      if (value) sum += *value * layout.time[i].factor;
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
  std::fill_n(places.begin(), layout.items.size(), ItemPlace{-1, 0});
  if (layout.text) return locate_cells(layout, frame, places);
  if (layout.list) return locate_list(layout, frame, places);
  return layout.masks.empty() || locate_masked(layout, frame, places);
}

std::optional<std::size_t> length_of(const FrameLayout& layout, std::string_view bytes) {
  if (layout.text) return length_of_line(layout, bytes);
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
  if (layout.text) return sound_line(layout, frame);
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
  const LocatedFrame located{bytes, places};
  content.unreadable = 0;
  read_fields(layout, located, content);
  read_counter_of(layout, located, content);
  read_time_of(layout, located, content);
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
