#include <fmt/format.h>

#include <algorithm>

#include "tumble/units/error.hpp"
#include "tumble/wire/declaration/declared.hpp"

namespace tumble::declaration {

namespace {

constexpr int longest_frame = 8192;  ///< [byte]

/// {by = "counter", frames = 10}: how many frames in a row must count.
int read_lock(tables::Section& section, FrameLayout& layout, Declared& declared) {
  const auto* table = section.table("sync");
  if (!table) return 0;
  tables::Section lock = declared.draft.section(*table, "sync");
  if (lock.text("by").value_or("") != "counter") lock.problem_at("by", "\"counter\" is expected");
  const int frames = lock.integer("frames").value_or(10);
  if (frames < 4 || frames > 1000) lock.problem_at("frames", "4 to 1000 frames that count are expected");
  lock.close();
  layout.sync.clear();
  layout.sync_mask.clear();
  return frames;
}

/// The first and the last bytes. Returns how many frames in a row must count, where their counter is in place of these.
int read_sync(tables::Section& section, FrameLayout& layout, Declared& declared) {
  const auto* node = section.find("sync");
  const int lock = node && node->is_table() ? read_lock(section, layout, declared) : 0;
  parse_at(section, "sync", [&] {
    if (const auto text = lock == 0 && node ? section.text("sync") : std::nullopt) {
      layout.sync_mask.clear();
      layout.sync = parse_hex(*text, &layout.sync_mask);
    }
    if (const auto text = section.text("end")) layout.end = parse_hex(*text);
  });
  if (layout.sync.empty() && lock == 0) {
    section.missing("sync", "\"FE 81 FF 55\"");
    layout.sync = layout.sync_mask = std::string(1, '\xff');
  }
  if (!layout.sync_mask.empty() && layout.sync_mask.front() == '\0')
    section.problem_at("sync", "the first byte must not be ..");
  return lock;
}

/// Frames that are found by their counter are all of one length, and have it at one place.
void lock_by_counter(tables::Section& section, int lock, FrameLayout& layout) {
  if (lock == 0) return;
  if (!layout.counter || layout.counter->step == 0 || layout.counter->number.item >= 0 || layout.counter->number.at < 0)
    section.problem_at("sync", "frames found by their counter need counter = {at = ...} with a step that is known");
  else
    layout.counter->lock = lock;
  if (layout.length_number || !layout.masks.empty() || layout.list)
    section.problem_at("sync", "frames found by their counter have a fixed length");
}

void read_length(tables::Section& section, bool big, FrameLayout& layout, Declared& declared) {
  const auto* node = section.find("length");
  if (!node || node->is_integer()) {
    const auto length = section.integer("length").value_or(layout.length);
    if (node) layout.length_number.reset();
    layout.length = length;
    return;
  }
  const auto* table = section.table("length");
  if (!table) return;
  tables::Section length = declared.draft.section(*table, "length");
  layout.length = length.integer("least").value_or(static_cast<int>(layout.sync.size()));
  layout.longest = length.integer("longest").value_or(512);
  layout.length_add = static_cast<int>(std::clamp<long long>(whole_of(length, "add").value_or(0), -512, 512));
  layout.length_number = number_of(length, big, "u8", layout);
  const FrameNumber& number = *layout.length_number;
  layout.length = std::max({layout.length, number.at + number.bytes, layout.length_add});
  if (number.at < 0 || number.kind != FrameNumber::Kind::natural)
    length.problem_at("at", "a natural number counted from the begin of the frame is expected");
  if (layout.longest > longest_frame) length.problem_at("longest", say("at most {} bytes", longest_frame));
  length.close();
}

void read_list(tables::Section& section, bool big, FrameLayout& layout, Declared& declared) {
  const auto* table = section.table("items");
  if (!table) return;
  tables::Section items = declared.draft.section(*table, "items");
  FrameItemList list;
  const auto bytes_of = [&](const char* key) {
    const auto text = items.text(key).value_or("u8");
    if (text != "u8" && text != "u16") items.problem_at(key, "\"u8\" or \"u16\" is expected");
    return text == "u16" ? 2 : 1;
  };
  list.from = items.integer("from").value_or(0);
  list.to = static_cast<int>(std::clamp<long long>(whole_of(items, "to").value_or(0), -512, 0));
  list.id_bytes = bytes_of("id");
  list.size_bytes = bytes_of("size");
  list.big = order_of(items, big);
  const auto first = items.text("first").value_or("id");
  if (first != "id" && first != "size") items.problem_at("first", "\"id\" or \"size\" is expected");
  list.size_first = first == "size";
  if (const auto* node = items.find("size_counts_head")) list.size_counts_head = node->value_or(false);
  if (!layout.length_number) items.problem("a frame with items needs length = {at = ..., add = ...}");
  layout.length = std::max(layout.length, std::min(list.from, longest_frame) - list.to);
  items.close();
  layout.list = list;
}

void read_masks(tables::Section& section, bool big, FrameLayout& layout, Declared& declared) {
  const auto tables = tables_at(section, "masks");
  if (tables.empty()) return;
  layout.masks.clear();
  for (const auto* table : tables) {
    tables::Section mask = declared.draft.section(*table, "masks");
    FrameMask read{number_of(mask, big, "u16", layout), mask.integers("sizes")};
    if (read.number.at < 0 || read.number.kind != FrameNumber::Kind::natural || read.number.bits > 63)
      mask.problem_at("at", "a natural number of up to 63 bits, counted from the begin of the frame, is expected");
    if (read.sizes.empty() || read.sizes.size() > static_cast<std::size_t>(std::min(read.number.bits, 63)))
      mask.problem_at("sizes", "the size of the piece of each bit is expected, from the lowest bit");
    for (int& size : read.sizes)
      if (size > 512) mask.problem_at("sizes", "at most 512 bytes"), size = 0;
    layout.length = std::max(layout.length, read.number.at + read.number.bytes);
    mask.close();
    layout.masks.push_back(read);
  }
  layout.masks_from = section.integer("from").value_or(layout.length);
  layout.masks_tail = section.integer("tail").value_or(0);
  if (!section.find("from")) section.missing("from", "4");
  if (!section.find("tail")) section.missing("tail", "2");
  if (layout.length_number || layout.list)
    section.problem("masks say the length: neither length nor items belong here");
  if (layout.masks_from > 512 || layout.masks_tail > 64 || layout.masks_from < layout.length)
    section.problem_at("from", "the pieces begin behind the masks, within 512 bytes, and at most 64 bytes follow them");
  layout.length = std::clamp(layout.masks_from, 0, 512) + std::clamp(layout.masks_tail, 0, 64);
  layout.longest = 2048;
}

/// How a frame of bytes begins and ends, and what it is made of. Returns what read_sync does.
int read_bytes(tables::Section& section, bool big, FrameLayout& layout, Declared& declared) {
  const int lock = read_sync(section, layout, declared);
  read_length(section, big, layout, declared);
  read_list(section, big, layout, declared);
  read_masks(section, big, layout, declared);
  const int least = std::max(static_cast<int>(layout.sync.size() + layout.end.size()), 1);
  if (layout.length < least || layout.length > longest_frame) {
    section.problem(say("length is needed, {} to {} bytes", least, longest_frame));
    layout.length = std::clamp(layout.length, std::min(least, longest_frame), longest_frame);
  }
  return lock;
}

/// The frame of that name, of those before, as it is.
FrameLayout like(tables::Section& section, const Declared& declared) {
  const auto name = section.text("like");
  if (!name) return {};
  for (const FrameLayout& frame : declared.codec.frames)
    if (frame.name == *name) return frame;
  section.problem_at("like", say("there is no frame '{}' before this one", *name));
  return {};
}

}  // namespace

void read_layout(const toml::table& table, Declared& declared) {
  const auto title = table["name"].value_or(std::string());
  tables::Section section =
      declared.draft.section(table, title.empty() ? Sentence("[[frame]]") : say("[[frame]] '{}'", title));
  FrameLayout layout = like(section, declared);
  section.find("name");
  layout.name = title.empty() ? std::to_string(declared.codec.frames.size() + 1) : title;
  const bool big = order_of(section, declared.big);
  const bool line = read_line(section, layout);
  const int lock = line ? 0 : read_bytes(section, big, layout, declared);
  read_checks(section, big, layout, declared);
  read_channels(section, big, layout, declared);
  read_counter(section, big, layout, declared);
  read_time(section, big, layout, declared);
  read_statuses(section, big, layout, declared);
  if (line) close_line(section, layout);
  lock_by_counter(section, lock, layout);
  if (layout.sync.size() > 512 || layout.end.size() > 64) section.problem("sync or end is too long");
  section.close();
  declared.codec.frames.push_back(layout);
}

}  // namespace tumble::declaration
