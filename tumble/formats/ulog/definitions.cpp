#include "tumble/formats/ulog/definitions.hpp"

#include <charconv>

namespace tumble::ulog {
namespace {

using topics::Number;

constexpr std::size_t largest = 65535;     ///< [bytes] a message
constexpr int deepest = 16;                ///< formats within formats
constexpr std::size_t spread_out = 31;     ///< arrays up to this length are channels; those of bursts have 32
constexpr std::size_t most_places = 1000;  ///< of one format: more is no instrument

bool is_padding(const Field& field) { return field.name.starts_with("_padding"); }

std::optional<Field> field_of(std::string_view text) {
  const auto space = text.find(' ');
  if (space == text.npos || space == 0 || space + 1 == text.size()) return std::nullopt;
  Field field{std::string(text.substr(0, space)), 1, std::string(text.substr(space + 1))};
  const auto open = field.type.find('[');
  if (open == std::string::npos) return field;
  const char* const end = field.type.data() + field.type.size();
  const auto [stop, error] = std::from_chars(field.type.data() + open + 1, end, field.length);
  if (error != std::errc() || stop + 1 != end || *stop != ']' || field.length == 0) return std::nullopt;
  field.type.resize(open);
  return field;
}

/// Sizes of formats that are known, so that formats within formats are looked at once.
using Known = std::map<std::string, std::optional<std::size_t>, std::less<>>;

std::optional<std::size_t> whole_size(const Definitions& definitions, const std::string& format, int depth,
                                      Known& known) {
  if (const auto number = number_of(format)) return topics::size_of(*number);
  if (format == "char") return 1;
  if (const auto found = known.find(format); found != known.end()) return found->second;
  const auto definition = definitions.find(format);
  if (definition == definitions.end() || depth > deepest) return std::nullopt;
  known[format] = std::nullopt;  // met again within itself
  std::size_t size = 0;
  for (const Field& field : definition->second) {
    const auto one = whole_size(definitions, field.type, depth + 1, known);
    if (!one || field.length > largest || (size += *one * field.length) > largest) return std::nullopt;
  }
  return known[format] = size;
}

struct Walk {
  const Definitions& definitions;
  Known& known;
  std::vector<Place>& places;

  void into(const std::string& format, const std::string& prefix, std::size_t offset, int depth) const {
    if (depth > deepest) return;
    for (const Field& field : definitions.find(format)->second) {
      const std::size_t size = whole_size(definitions, field.type, 0, known).value_or(0);
      take(field, prefix + field.name, offset, size, depth);
      offset += size * field.length;
    }
  }

  void take(const Field& field, const std::string& name, std::size_t offset, std::size_t size, int depth) const {
    if (is_padding(field) || field.type == "char") return;
    const auto number = number_of(field.type);
    if (!number && size == 0) return;  // nothing is in it, however often
    const bool apart = field.length > 1 && (!number || field.length <= spread_out);
    if (number && !apart && places.size() < most_places) places.push_back({name, offset, *number, field.length});
    for (std::size_t k = 0; k < field.length && places.size() < most_places; ++k) {
      const std::string element = apart ? name + "." + std::to_string(k) : name;
      if (number && apart) places.push_back({element, offset + k * size, *number, 1});
      if (!number) into(field.type, element + ".", offset + k * size, depth + 1);
      if (!apart) break;
    }
  }
};

}  // namespace

std::optional<Number> number_of(std::string_view type) {
  struct Row {
    std::string_view type;
    Number number;
  };
  static constexpr Row rows[] = {{"int8_t", Number::i8},    {"uint8_t", Number::u8},   {"int16_t", Number::i16},
                                 {"uint16_t", Number::u16}, {"int32_t", Number::i32},  {"uint32_t", Number::u32},
                                 {"int64_t", Number::i64},  {"uint64_t", Number::u64}, {"float", Number::f32},
                                 {"double", Number::f64},   {"bool", Number::u8}};
  for (const Row& row : rows)
    if (row.type == type) return row.number;
  return std::nullopt;
}

bool define(std::string_view text, Definitions& definitions) {
  const auto colon = text.find(':');
  if (colon == text.npos || colon == 0) return false;
  std::vector<Field> fields;
  for (std::string_view rest = text.substr(colon + 1); !rest.empty();) {
    const auto end = rest.find(';');
    const auto one = rest.substr(0, end);
    rest.remove_prefix(end == rest.npos ? rest.size() : end + 1);
    if (one.empty()) continue;
    auto field = field_of(one);
    if (!field) return false;
    fields.push_back(std::move(*field));
  }
  definitions[std::string(text.substr(0, colon))] = std::move(fields);
  return true;
}

bool holds(const Definitions& definitions, const std::string& format, const std::set<std::string>& names) {
  std::set<std::string> met;
  std::vector<std::string> open{format};
  while (!open.empty()) {
    const std::string next = std::move(open.back());
    open.pop_back();
    const auto definition = definitions.find(next);
    if (definition == definitions.end() || !met.insert(next).second) continue;
    if (names.contains(next)) return true;
    for (const Field& field : definition->second) open.push_back(field.type);
  }
  return false;
}

std::optional<Size> size_of(const Definitions& definitions, const std::string& format) {
  Known known;
  const auto whole = whole_size(definitions, format, 0, known);
  if (!whole || *whole == 0) return std::nullopt;
  Size size{*whole, *whole};
  const auto& fields = definitions.find(format)->second;
  for (auto field = fields.rbegin(); field != fields.rend() && is_padding(*field); ++field)
    size.least -= *whole_size(definitions, field->type, 0, known) * field->length;
  return size;
}

std::vector<Place> places_in(const Definitions& definitions, const std::string& format) {
  Known known;
  std::vector<Place> places;
  Walk{definitions, known, places}.into(format, "", 0, 0);
  return places;
}

}  // namespace tumble::ulog
