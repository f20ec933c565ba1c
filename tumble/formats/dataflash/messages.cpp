#include "tumble/formats/dataflash/messages.hpp"

#include <algorithm>
#include <cstring>

#include "tumble/formats/file/window.hpp"

namespace tumble::dataflash {
namespace {

using topics::Number;

constexpr std::uint8_t fmt_id = 128;
constexpr std::size_t fmt_length = 89;  ///< [bytes]: head, type, length, name 4, format 16, labels 64
constexpr std::size_t longest_message = 255;

/// Up to the first zero; control characters replaced.
std::string printable(const char* bytes, std::size_t size) {
  std::string text(bytes, std::find(bytes, bytes + size, '\0'));
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

Description description_of(const char* fmt) {
  Description description;
  description.length = static_cast<unsigned char>(fmt[4]);
  description.name = printable(fmt + 5, 4);
  const std::string types = printable(fmt + 9, 16), labels = printable(fmt + 25, 64);
  std::size_t offset = message_head, begin = 0;
  for (const char type : types) {
    const auto comma = labels.find(',', begin);
    if (begin > labels.size() || size_of(type) == 0) return {description.name, description.length, {}, false};
    description.fields.push_back({labels.substr(begin, comma - begin), type, offset});
    offset += size_of(type);
    begin = comma == labels.npos ? labels.size() + 1 : comma + 1;
  }
  if (offset > description.length) description.fields.clear();
  return description;
}

bool same(const Description& a, const Description& b) {
  const auto same_field = [](const Field& x, const Field& y) { return x.label == y.label && x.type == y.type; };
  return a.name == b.name && a.length == b.length && std::ranges::equal(a.fields, b.fields, same_field);
}

/// Takes the description in a FMT message.
void describe(const char* fmt, Descriptions& descriptions) {
  Description described = description_of(fmt);
  Description& known = descriptions[static_cast<unsigned char>(fmt[3])];
  if (described.name.empty() || described.length < message_head) return;
  if (known.name.empty())
    known = std::move(described);
  else if (!same(known, described))
    known.ambiguous = true;
}

/// Erased memory reads as one of these.
bool is_padding(char byte) { return byte == '\0' || byte == '\xff'; }

class Walker {
 public:
  Walker(const std::string& path, Descriptions& descriptions, const Progress& progress)
      : descriptions_(descriptions), progress_(progress), window_(path) {}

  template <class Take>
  Damage run(const Take& take) {
    for (std::size_t reported = 0; window_.holds(message_head);) {
      const std::size_t at = window_.position();
      if (at - reported > std::size_t{1} << 22) {
        reported = at;
        report(progress_, static_cast<double>(at) / static_cast<double>(window_.size()), "reading");
      }
      const std::size_t length = length_at(window_.data());
      if (length == 0 || !ends(length)) {
        if (length > 0 && !window_.holds(length)) return cut();
        find_next();
        continue;
      }
      const auto id = static_cast<std::uint8_t>(window_.data()[2]);
      if (id == fmt_id) describe(window_.data(), descriptions_);
      take(id, window_.data());
      window_.skip(length);
    }
    return cut();
  }

 private:
  /// 0 where no message that is described begins.
  std::size_t length_at(const char* head) const {
    if (head[0] != magic[0] || head[1] != magic[1]) return 0;
    const auto id = static_cast<std::uint8_t>(head[2]);
    return id == fmt_id ? fmt_length : descriptions_[id].length;
  }

  /// Whether the message is whole and another follows, or nothing, or erased memory: else bytes are missing in it.
  bool ends(std::size_t length) {
    if (!window_.holds(length + magic.size())) return window_.available() == length || pads(length);
    const char* const next = window_.data() + length;
    return std::memcmp(next, magic.data(), magic.size()) == 0 || pads(length);
  }

  bool pads(std::size_t length) const {
    const char* const end = window_.data() + window_.available();
    const char* const next = window_.data() + length;
    return next < end && is_padding(*next) && std::all_of(next, std::min(next + magic.size(), end), is_padding);
  }

  /// The bytes at the end are a message that is not whole, unless they are erased memory.
  Damage cut() {
    const char* const begin = window_.data();
    if (!std::all_of(begin, begin + window_.available(), is_padding)) damage_.cut_off = window_.available();
    return damage_;
  }

  bool at_magic() const { return std::memcmp(window_.data(), magic.data(), magic.size()) == 0; }

  /// To the next place where a message may begin, or to the end of the file.
  void find_next() {
    const std::size_t start = window_.position();
    const bool undescribed = at_magic() && length_at(window_.data()) == 0;
    bool padding = true;
    do {
      padding = padding && is_padding(*window_.data());
      window_.skip(1);
    } while (window_.holds(message_head) && !at_magic());
    if (!window_.holds(message_head)) {  // what remains at the end
      padding = padding && std::all_of(window_.data(), window_.data() + window_.available(), is_padding);
      window_.skip(window_.available());
    }
    damage_.undescribed += undescribed;
    if (padding || undescribed) return;
    if (damage_.stretches++ == 0) damage_.first = start;
    damage_.bytes += window_.position() - start;
  }

  Descriptions& descriptions_;
  const Progress& progress_;
  file::Window window_;
  Damage damage_;
};

}  // namespace

std::size_t size_of(char type) {
  switch (type) {
    case 'b':
    case 'B':
    case 'M':
      return 1;
    case 'h':
    case 'H':
    case 'c':
    case 'C':
    case 'g':
      return 2;
    case 'i':
    case 'I':
    case 'f':
    case 'e':
    case 'E':
    case 'L':
    case 'n':
      return 4;
    case 'd':
    case 'q':
    case 'Q':
      return 8;
    case 'N':
      return 16;
    case 'Z':
    case 'a':
      return 64;
    default:
      return 0;
  }
}

std::optional<Number> number_of(char type) {
  struct Row {
    char type;
    Number number;
  };
  static constexpr Row rows[] = {{'b', Number::i8},  {'B', Number::u8},  {'M', Number::u8},  {'h', Number::i16},
                                 {'H', Number::u16}, {'c', Number::i16}, {'C', Number::u16}, {'i', Number::i32},
                                 {'I', Number::u32}, {'e', Number::i32}, {'E', Number::u32}, {'L', Number::i32},
                                 {'q', Number::i64}, {'Q', Number::u64}, {'f', Number::f32}, {'d', Number::f64}};
  for (const Row& row : rows)
    if (row.type == type) return row.number;
  return std::nullopt;
}

const Field* find_field(const Description& description, std::string_view label) {
  const auto found = std::ranges::find(description.fields, label, &Field::label);
  return found == description.fields.end() ? nullptr : &*found;
}

std::string text_of(const Description& description, const char* message, std::string_view label) {
  const Field* const field = find_field(description, label);
  const bool text = field && (field->type == 'n' || field->type == 'N' || field->type == 'Z');
  return text ? printable(message + field->offset, size_of(field->type)) : "";
}

std::optional<double> value_of(const Description& description, const char* message, std::string_view label) {
  const Field* const field = find_field(description, label);
  const auto number = field ? number_of(field->type) : std::nullopt;
  if (!number) return std::nullopt;
  return topics::number_at(message + field->offset, *number);
}

const Field* time_field(const Description& description) {
  for (const char* label : {"SampleUS", "TimeUS", "TimeMS"}) {
    const Field* const field = find_field(description, label);
    const auto number = field ? number_of(field->type) : std::nullopt;
    if (number && topics::is_integer(*number)) return field;
  }
  return nullptr;
}

double ticks_of(const Field& time) { return time.label == "TimeMS" ? 1e3 : 1e6; }

std::optional<double> time_of(const Description& description, const char* message) {
  const Field* const field = time_field(description);
  if (!field) return std::nullopt;
  return topics::number_at(message + field->offset, *number_of(field->type)) / ticks_of(*field);
}

Damage walk(const std::string& path, Descriptions& descriptions, const Progress& progress,
            const std::function<void(std::uint8_t, const char*)>& take) {
  return Walker(path, descriptions, progress).run(take);
}

}  // namespace tumble::dataflash
