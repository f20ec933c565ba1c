#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/tables/document.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/wire/declaration/declared.hpp"
#include "tumble/wire/declaration/format.hpp"

namespace tumble {

namespace {

using declaration::Declared;
using tables::Section;

void read_link(Section& root, Declared& declared) {
  FrameLink& link = declared.codec.link;
  if (const auto* table = root.table("link")) {
    Section section = declared.draft.section(*table, "link");
    link.baud = section.integer("baud").value_or(0);
    link.format = section.text("format").value_or("8N1");
    section.close();
  }
  const auto lines = [&](const char* key, auto& to) {
    for (const auto* table : declaration::tables_at(root, key)) {
      Section section = declared.draft.section(*table, key);
      const std::string send = declaration::bytes_at(section, "send");
      to.emplace_back(send, declaration::bytes_at(section, "expect"));
      section.close();
    }
  };
  lines("start", link.start);
  lines("stop", link.stop);
}

void read_scales(const toml::table* table, Declared& declared) {
  if (!table) return;
  Section section = declared.draft.section(*table, "[scale]");
  for (const auto& name : section.unread()) {
    const auto text = section.text(name);
    if (!text) continue;
    declaration::parse_at(section, name, [&] {
      if (*text != declaration::chosen_by_variant) declaration::parse_scale(*text, {});
      declared.scales[name] = *text;
    });
  }
}

/// The scales of the variants that are wanted, in place of those of [scale].
void read_variants(Section& root, const std::vector<std::string>& wanted, Declared& declared) {
  const auto* table = root.table("variant");
  std::vector<std::string>& known = declared.codec.variants;
  if (table)
    for (const auto& [key, node] : *table) {
      known.emplace_back(key.str());
      const auto* variant = node.as_table();
      if (!variant) {
        root.problem_at("variant", "a table for each variant is expected, [variant.high_range]");
        continue;
      }
      Section section = declared.draft.section(*variant, "[variant." + known.back() + "]");
      section.text("note");
      const bool is_wanted = std::ranges::find(wanted, known.back()) != wanted.end();
      const auto* scales = section.table("scale");
      if (scales)
        for (const auto& [scale, value] : *scales)
          if (!declared.scales.contains(std::string(scale.str())))
            section.problem_at("scale", say("[scale] has no '{}'", scale.str()));
      if (is_wanted) read_scales(scales, declared);
      section.close();
    }
  for (const auto& name : wanted)
    if (std::ranges::find(known, name) == known.end())
      declared.draft.add(say("there is no variant '{}'{} (variants: {})", Name{name}, did_you_mean(name, known),
                             known.empty() ? Sentence("none") : say("{}", fmt::join(known, ", "))));
}

FrameVector::Value stated_value(Section& section, std::string_view key, const toml::node& node, const Unit& unit,
                                bool bare) {
  const auto* real = node.as_floating_point();
  const auto text = real ? fmt::format("{}", real->get()) : tables::text_of(node).value_or("");
  FrameVector::Value value{};
  declaration::parse_at(section, key, [&] {
    const double si = bare && unit.dimension() == Dimension{} ? parse_quantity(text).value : parse_si(text, unit);
    value = {si, declaration::half_of_last_digit(text) * std::abs(parse_quantity(text).unit.factor())};
  });
  return value;
}

void read_vector_values(Section& section, FrameVector& vector, Declared& declared) {
  const auto* table = section.table("values");
  if (!table) return section.missing("values", "{\"gyro.x\" = \"2.019593e-5 rad\"}");
  for (const auto& [key, node] : *table) {
    const std::string name(key.str());
    const auto channel = std::ranges::find(declared.codec.channels, name, &FrameChannel::name);
    if (channel == declared.codec.channels.end()) {
      std::vector<std::string> known;
      for (const auto& one : declared.codec.channels) known.push_back(one.name);
      section.problem_at("values", say("there is no channel '{}'{}", name, did_you_mean(name, known)));
      continue;
    }
    Unit unit = channel->unit;
    if (channel->increment) unit = Unit::parse("(" + unit.text() + ")*s");
    vector.values[name] = stated_value(section, "values", node, unit, !node.is_string());
  }
}

/// Bytes in hexadecimal digits, or a line; the end that its frame declares is added to a line.
void read_vector_bytes(Section& section, FrameVector& vector, const Declared& declared) {
  const auto line = section.text("line");
  declaration::parse_at(section, "hex",
                        [&] { vector.bytes = declaration::parse_hex(section.text("hex").value_or("")); });
  if (!line && !section.find("hex"))
    section.missing("hex", "\"FE 81 FF 55 ...\", or line = \"...\" for a line of text");
  if (line && section.find("hex")) section.problem("hex or line: a vector has one of these");
  if (!line) return;
  vector.bytes = *line;
  if (line->ends_with('\n') || line->ends_with('\r')) return;
  for (const FrameLayout& layout : declared.codec.frames)
    if (layout.text && line->starts_with(layout.sync)) {
      vector.bytes += layout.end;
      return;
    }
}

void read_vector(const toml::table& table, const std::string& variants, Declared& declared) {
  Section section = declared.draft.section(table, "[[vector]]");
  FrameVector vector;
  vector.place = declared.draft.problems.where(table.source());
  vector.source = section.text("source").value_or("");
  if (const auto* node = section.find("made_by_hand")) vector.made_by_hand = node->value_or(false);
  vector.variant = section.text("variant").value_or("");
  if (vector.source.empty() && !vector.made_by_hand) section.missing("source", "\"manual, page 12\"");
  read_vector_bytes(section, vector, declared);
  if (const auto counter = section.integer("counter")) vector.counter = static_cast<std::uint64_t>(*counter);
  if (const auto* node = section.find("time"))
    vector.time = stated_value(section, "time", *node, Unit::parse("s"), false);
  if (vector.variant == variants) read_vector_values(section, vector, declared);
  section.find("values");
  section.close();
  declared.codec.vectors.push_back(vector);
}

void require_uses(Declared& declared) {
  if (declared.codec.frames.empty()) declared.draft.add("there is no [[frame]]");
  const auto counted = [](const FrameLayout& layout) { return layout.counter && layout.counter->lock > 0; };
  if (declared.codec.frames.size() > 1 && std::ranges::any_of(declared.codec.frames, counted))
    declared.draft.add("a frame that is found by its counter is the only [[frame]]");
  if (declared.codec.frames.size() > 64) declared.draft.add("more than 64 [[frame]]");
  if (!declared.codec.frames.empty() && declared.codec.channels.empty()) declared.draft.add("no frame has a channel");
  if (declared.codec.vectors.empty() && declared.draft.sound())
    declared.draft.add(
        "there is no [[vector]]; give the bytes of one frame and the values that they mean, so that offsets, "
        "order and scales are tested");
}

}  // namespace

FrameCodec read_frames(std::string_view text, const std::string& file, const std::vector<std::string>& variants) {
  const toml::table document = tables::document_of(std::string(text), file);
  Declared declared{declaration::Draft(file)};
  Section root = declared.draft.section(document, "");
  FrameCodec& codec = declared.codec;
  codec.name = file;
  declaration::read_head(root, "\"KVH 1775 IMU\"", codec);
  codec.rate = root.quantity("rate", Unit::parse("Hz")).value_or(0.0);
  if (!(codec.rate >= 0.0 && codec.rate < 1e9)) root.problem_at("rate", "must be above zero");
  declared.big = declaration::order_of(root, false);
  declaration::parse_at(root, "between",
                        [&] { codec.between = declaration::parse_hex(root.text("between").value_or("")); });
  read_link(root, declared);
  read_scales(root.table("scale"), declared);
  read_variants(root, variants, declared);
  for (const auto* table : declaration::tables_at(root, "frame")) declaration::read_layout(*table, declared);
  for (const auto* table : declaration::tables_at(root, "vector")) read_vector(*table, joined(variants, ","), declared);
  root.close();
  require_uses(declared);
  declared.draft.require_sound();
  for (const auto& [scale, meaning] : declared.scales)
    if (meaning == declaration::chosen_by_variant) codec.unchosen.push_back(scale);
  std::erase_if(codec.vectors, [&](const FrameVector& vector) { return vector.variant != joined(variants, ","); });
  if (auto wrong = problems_of_vectors(codec); !wrong.empty()) throw Error(Error::Kind::bad_input, wrong);
  return codec;
}

}  // namespace tumble
