#include "tumble/wire/codec/encode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/wire/codec/checksum.hpp"
#include "tumble/wire/codec/content.hpp"
#include "tumble/wire/codec/number.hpp"

namespace tumble {

namespace codec {

std::optional<std::uint64_t> bits_for(const FrameNumber& number, double raw) {
  if (number.kind == FrameNumber::Kind::real)
    return number.bytes == 4 ? std::bit_cast<std::uint32_t>(static_cast<float>(raw))
                             : std::bit_cast<std::uint64_t>(raw);
  const double whole = std::nearbyint(raw);
  const bool natural = number.kind == FrameNumber::Kind::natural;
  const double top = std::ldexp(1.0, natural ? number.bits : number.bits - 1);
  if (!(whole >= (natural ? 0.0 : -top) && whole < top)) return std::nullopt;
  return natural ? static_cast<std::uint64_t>(whole) : static_cast<std::uint64_t>(static_cast<std::int64_t>(whole));
}

double raw_of(const FrameField& field, double value) {
  const double near = (value - field.zero) / field.factor;
  double up = near, down = near;
  for (int i = 0; i < 4; ++i) {
    if (up * field.factor + field.zero == value) return up;
    if (down * field.factor + field.zero == value) return down;
    up = std::nextafter(up, HUGE_VAL);
    down = std::nextafter(down, -HUGE_VAL);
  }
  return near;
}

std::vector<const FrameField*> chosen_fields(const FrameLayout& layout, const FrameContent& content) {
  std::vector<const FrameField*> chosen;
  std::vector<bool> done(content.present.size());
  for (const FrameField& field : layout.fields) {
    if (!content.present[field.channel] || done[field.channel]) continue;
    if (field.when && field.when->modulus > 0 && layout.counter && content.counter &&
        *content.counter % field.when->modulus != field.when->equals)
      continue;
    done[field.channel] = true;
    chosen.push_back(&field);
  }
  return chosen;
}

}  // namespace codec

namespace {

using codec::bits_for;
using codec::chosen_fields;
using codec::raw_of;

/// A frame while it is put together.
struct FrameDraft {
  const FrameCodec& codec;
  const FrameLayout& layout;
  std::string bytes;
  bool from_base;
  codec::ItemPlaces places;  // no values of their own: locate() sets them

  FrameDraft(const FrameCodec& its_codec, const FrameLayout& its_layout, std::string begun, bool on_base)
      : codec(its_codec), layout(its_layout), bytes(std::move(begun)), from_base(on_base) {}

  unsigned char* at(const FrameNumber& number) {
    const auto place = codec::place_of(number, bytes.size(), places);
    return place ? reinterpret_cast<unsigned char*>(bytes.data()) + *place : nullptr;
  }
};

[[noreturn]] void refuse_value(const FrameDraft& draft, const Name& what, const Sentence& why) {
  throw Error(Error::Kind::bad_input,
              say("{}: frame '{}': {}: {}", Name{draft.codec.name}, draft.layout.name, what, why));
}

/// Which items of the layout the content needs, in their order.
std::vector<std::size_t> needed_items(const FrameLayout& layout, const FrameContent& content,
                                      const std::vector<const FrameField*>& fields) {
  std::vector<bool> needed(layout.items.size());
  const auto need = [&](const FrameNumber& number) {
    if (number.item >= 0) needed[static_cast<std::size_t>(number.item)] = true;
  };
  for (const FrameField* field : fields) {
    need(field->number);
    if (field->when) need(field->when->number);
  }
  if (layout.counter && content.counter) need(layout.counter->number);
  if (content.time)
    for (const FrameTime& part : layout.time)
      if (part.choice == 0) need(part.number);
  std::vector<std::size_t> items;
  for (std::size_t i = 0; i < needed.size(); ++i)
    if (needed[i]) items.push_back(i);
  if (!layout.masks.empty()) std::ranges::sort(items, {}, [&](std::size_t item) { return layout.items[item].id; });
  return items;
}

void put_list(FrameDraft& draft, const std::vector<std::size_t>& items) {
  const FrameItemList& list = *draft.layout.list;
  const int head = list.id_bytes + list.size_bytes;
  const std::string tail = draft.bytes.substr(static_cast<std::size_t>(list.from));
  draft.bytes.resize(static_cast<std::size_t>(list.from));
  for (const std::size_t i : items) {
    const FrameItem& item = draft.layout.items[i];
    std::string piece(static_cast<std::size_t>(head + item.size), '\0');
    auto* const to = reinterpret_cast<unsigned char*>(piece.data());
    const int stated = item.size + (list.size_counts_head ? head : 0);
    codec::put_word(item.id, to + (list.size_first ? list.size_bytes : 0), list.id_bytes, list.big);
    codec::put_word(static_cast<std::uint64_t>(stated), to + (list.size_first ? 0 : list.id_bytes), list.size_bytes,
                    list.big);
    draft.bytes += piece;
  }
  draft.bytes += tail;
}

void put_masked(FrameDraft& draft, const std::vector<std::size_t>& items) {
  std::size_t size = static_cast<std::size_t>(draft.layout.masks_from + draft.layout.masks_tail);
  std::vector<std::uint64_t> bits(draft.layout.masks.size());
  for (const std::size_t i : items) {
    const auto id = draft.layout.items[i].id;
    bits[id / 64] |= std::uint64_t{1} << id % 64;
    size += static_cast<std::size_t>(draft.layout.masks[id / 64].sizes[id % 64]);
  }
  draft.bytes.assign(size, '\0');
  for (std::size_t m = 0; m < bits.size(); ++m)
    codec::put_natural(draft.layout.masks[m].number, bits[m],
                       reinterpret_cast<unsigned char*>(draft.bytes.data()) + draft.layout.masks[m].number.at);
}

void put_skeleton(FrameDraft& draft, const FrameContent& content, const std::vector<const FrameField*>& fields) {
  const FrameLayout& layout = draft.layout;
  const auto items = needed_items(layout, content, fields);
  draft.bytes.assign(static_cast<std::size_t>(layout.length), '\0');
  if (layout.list) put_list(draft, items);
  if (!layout.masks.empty()) put_masked(draft, items);
  for (std::size_t i = 0; i < layout.sync.size(); ++i)
    draft.bytes[i] =
        static_cast<char>((draft.bytes[i] & ~layout.sync_mask[i]) | (layout.sync[i] & layout.sync_mask[i]));
  draft.bytes.replace(draft.bytes.size() - layout.end.size(), layout.end.size(), layout.end);
  if (layout.length_number)
    codec::put_natural(*layout.length_number,
                       static_cast<std::uint64_t>(static_cast<std::int64_t>(draft.bytes.size()) - layout.length_add),
                       reinterpret_cast<unsigned char*>(draft.bytes.data()) + layout.length_number->at);
}

void put_time_part(FrameDraft& draft, const FrameTime& part, double raw, double time) {
  unsigned char* const to = draft.at(part.number);
  if (!to) return;
  const auto bits = bits_for(part.number, raw);
  if (!bits) refuse_value(draft, Name{"time"}, say("{} s does not fit", time));
  codec::put_natural(part.number, *bits, to);
}

void put_time(FrameDraft& draft, double time) {
  if (draft.layout.time.size() == 1) {
    const FrameTime& only = draft.layout.time.front();
    return put_time_part(draft, only, time / only.factor, time);
  }
  std::vector<const FrameTime*> parts;
  for (const FrameTime& part : draft.layout.time)
    if (draft.at(part.number) && (parts.empty() || parts.front()->choice == part.choice)) parts.push_back(&part);
  std::ranges::stable_sort(parts, std::ranges::greater{}, [](const FrameTime* part) { return part->factor; });
  for (const FrameTime* part : parts) {
    const double exact = time / part->factor;
    const bool whole = part != parts.back() && part->number.kind != FrameNumber::Kind::real;
    const double raw = whole ? std::floor(exact + 1e-9) : exact;
    put_time_part(draft, *part, raw, time);
    time -= raw * part->factor;
  }
}

void put_field(FrameDraft& draft, const FrameField& field, double value) {
  const std::string& name = draft.codec.channels[field.channel].name;
  unsigned char* const to = draft.at(field.number);
  if (!to) refuse_value(draft, Name{name}, "the frame has no room for it");
  if (std::isnan(value) && (draft.from_base || field.number.kind != FrameNumber::Kind::real)) return;
  const auto bits = bits_for(field.number, raw_of(field, value));
  if (!bits) refuse_value(draft, Name{name}, say("{:g} (SI) does not fit into its {} bits", value, field.number.bits));
  codec::put_natural(field.number, *bits, to);
}

/// False: the condition stands in the base, and is not met.
bool make_true(FrameDraft& draft, const FrameCondition& condition) {
  unsigned char* const to = draft.at(condition.number);
  if (!to) return false;
  const auto value = codec::natural_of(condition.number, to);
  if ((condition.modulus ? value % condition.modulus : value) == condition.equals) return true;
  if (draft.from_base || condition.modulus > 0) return false;
  codec::put_natural(condition.number, condition.equals, to);
  return true;
}

void locate_items(FrameDraft& draft) {
  if (!codec::locate(draft.layout, draft.bytes, draft.places))
    throw Error(Error::Kind::bad_input,
                say("{}: these bytes are no frame '{}'", Name{draft.codec.name}, draft.layout.name));
}

void put_counter_and_time(FrameDraft& draft, const FrameContent& content) {
  const FrameLayout& layout = draft.layout;
  if (layout.counter && content.counter)
    if (unsigned char* const to = draft.at(layout.counter->number))
      codec::put_natural(layout.counter->number, *content.counter % layout.counter->modulus, to);
  if (content.time && !layout.time.empty()) put_time(draft, *content.time);
}

/// Where the fields stand in the layout.
std::vector<std::size_t> numbers_of(const FrameLayout& layout, const std::vector<const FrameField*>& fields) {
  std::vector<std::size_t> numbers;
  for (const FrameField* field : fields) numbers.push_back(static_cast<std::size_t>(field - layout.fields.data()));
  return numbers;
}

/// All that changes from frame to frame, in frames that are not made from others.
void put_content(FrameDraft& draft, const FrameContent& content, const std::vector<std::size_t>& fields) {
  locate_items(draft);
  put_counter_and_time(draft, content);
  for (const FrameStatus& status : draft.layout.statuses) make_true(draft, status.good);
  for (const std::size_t number : fields) {
    const FrameField& field = draft.layout.fields[number];
    if (field.when && !make_true(draft, *field.when))
      refuse_value(draft, Name{draft.codec.channels[field.channel].name},
                   "the frame cannot carry it with this counter");
    put_field(draft, field, content.values[field.channel]);
  }
  for (const FrameChecksum& check : draft.layout.checks) codec::put_checksum(check, draft.bytes);
}

}  // namespace

std::string encode_frame(const FrameCodec& codec, const FrameContent& content, std::string_view base) {
  const FrameLayout& layout = codec.frames.at(content.frame);
  if (layout.text) return codec::encode_line(codec, content, base);
  FrameDraft draft(codec, layout, std::string(base), !base.empty());
  if (!draft.from_base) {
    const auto fields = chosen_fields(layout, content);
    put_skeleton(draft, content, fields);
    put_content(draft, content, numbers_of(layout, fields));
    return draft.bytes;
  }
  locate_items(draft);
  put_counter_and_time(draft, content);
  for (const FrameField& field : layout.fields)
    if (content.present[field.channel] && draft.at(field.number) && (!field.when || make_true(draft, *field.when)))
      put_field(draft, field, content.values[field.channel]);
  for (const FrameChecksum& check : layout.checks) codec::put_checksum(check, draft.bytes);
  return draft.bytes;
}

/// Which fields are chosen may depend on the counter: then nothing is kept.
bool FrameEncoder::keeps(const FrameLayout& layout) {
  return !layout.text && std::ranges::none_of(layout.fields, [](const FrameField& field) { return bool(field.when); });
}

void FrameEncoder::append(const FrameCodec& codec, const FrameContent& content, std::string& out) {
  const FrameLayout& layout = codec.frames.at(content.frame);
  const bool same = !skeleton_.empty() && content.frame == frame_ && content.present == present_ &&
                    content.counter.has_value() == counted_ && content.time.has_value() == timed_;
  if (!same && !keeps(layout)) {
    out += encode_frame(codec, content);
    return;
  }
  FrameDraft draft(codec, layout, std::move(draft_), false);
  if (!same) {
    const auto fields = chosen_fields(layout, content);
    put_skeleton(draft, content, fields);
    fields_ = numbers_of(layout, fields);
    skeleton_ = draft.bytes;
    frame_ = content.frame;
    present_ = content.present;
    counted_ = content.counter.has_value();
    timed_ = content.time.has_value();
  }
  draft.bytes = skeleton_;
  put_content(draft, content, fields_);
  out += draft.bytes;
  draft_ = std::move(draft.bytes);
}

}  // namespace tumble
