#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/tables/document.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/wire/controller/template.hpp"
#include "tumble/wire/declaration/draft.hpp"
#include "tumble/wire/declaration/format.hpp"

namespace tumble {

namespace {

using declaration::Draft;
using tables::Section;

void read_link(Section& root, Draft& draft) {
  FrameLink& link = draft.codec.link;
  if (const auto* table = root.table("link")) {
    Section section(*table, "link", draft.problems);
    link.baud = section.integer("baud").value_or(0);
    link.format = section.text("format").value_or("8N1");
    section.close();
  }
  const auto lines = [&](const char* key, auto& to) {
    for (const auto* table : declaration::tables_at(root, key)) {
      Section section(*table, key, draft.problems);
      std::string bytes[2];
      for (const auto& [at, name] : {std::pair{0, "send"}, std::pair{1, "expect"}}) try {
          bytes[at] = controller::latin1(section.text(name).value_or(""));
        } catch (const Error& error) {
          for (const auto& problem : error.problems) section.problem_at(name, problem);
        }
      to.emplace_back(bytes[0], bytes[1]);
      section.close();
    }
  };
  lines("start", link.start);
  lines("stop", link.stop);
}

void read_scales(const toml::table* table, Draft& draft) {
  if (!table) return;
  Section section(*table, "[scale]", draft.problems);
  for (const auto& name : section.unread()) {
    const auto text = section.text(name);
    if (!text) continue;
    try {
      if (*text != declaration::chosen_by_variant) declaration::parse_scale(*text, {});
      draft.scales[name] = *text;
    } catch (const Error& error) {
      for (const auto& problem : error.problems) section.problem_at(name, problem);
    }
  }
}

/// The scales of the variants that are wanted, in place of those of [scale].
void read_variants(Section& root, const std::vector<std::string>& wanted, Draft& draft) {
  const auto* table = root.table("variant");
  std::vector<std::string>& known = draft.codec.variants;
  if (table)
    for (const auto& [key, node] : *table) {
      known.emplace_back(key.str());
      const auto* variant = node.as_table();
      if (!variant) {
        root.problem_at("variant", "a table for each variant is expected, [variant.high_range]");
        continue;
      }
      Section section(*variant, "[variant." + known.back() + "]", draft.problems);
      section.text("note");
      const bool is_wanted = std::ranges::find(wanted, known.back()) != wanted.end();
      const auto* scales = section.table("scale");
      if (scales)
        for (const auto& [scale, value] : *scales)
          if (!draft.scales.contains(std::string(scale.str())))
            section.problem_at("scale", say("[scale] has no '{}'", scale.str()));
      if (is_wanted) read_scales(scales, draft);
      section.close();
    }
  for (const auto& name : wanted)
    if (std::ranges::find(known, name) == known.end())
      draft.problems.all.push_back(in_file(
          draft.problems.file, say("there is no variant '{}'{} (variants: {})", Name{name}, did_you_mean(name, known),
                                   known.empty() ? Sentence("none") : say("{}", fmt::join(known, ", ")))));
}

FrameVector::Value stated_value(Section& section, std::string_view key, const toml::node& node, const Unit& unit,
                                bool bare) {
  const auto* real = node.as_floating_point();
  const auto text = real ? fmt::format("{}", real->get()) : tables::text_of(node).value_or("");
  try {
    const double si = bare && unit.dimension() == Dimension{} ? parse_quantity(text).value : parse_si(text, unit);
    return {si, declaration::half_of_last_digit(text) * std::abs(parse_quantity(text).unit.factor())};
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at(key, problem);
  }
  return {};
}

void read_vector_values(Section& section, FrameVector& vector, Draft& draft) {
  const auto* table = section.table("values");
  if (!table) return section.missing("values", "{\"gyro.x\" = \"2.019593e-5 rad\"}");
  for (const auto& [key, node] : *table) {
    const std::string name(key.str());
    const auto channel = std::ranges::find(draft.codec.channels, name, &FrameChannel::name);
    if (channel == draft.codec.channels.end()) {
      std::vector<std::string> known;
      for (const auto& one : draft.codec.channels) known.push_back(one.name);
      section.problem_at("values", say("there is no channel '{}'{}", name, did_you_mean(name, known)));
      continue;
    }
    Unit unit = channel->unit;
    if (channel->increment) unit = Unit::parse("(" + unit.text() + ")*s");
    vector.values[name] = stated_value(section, "values", node, unit, !node.is_string());
  }
}

/// Bytes in hexadecimal digits, or a line; the end that its frame declares is added to a line.
void read_vector_bytes(Section& section, FrameVector& vector, const Draft& draft) {
  const auto line = section.text("line");
  declaration::parse_at(section, "hex",
                        [&] { vector.bytes = declaration::parse_hex(section.text("hex").value_or("")); });
  if (!line && !section.find("hex"))
    section.missing("hex", "\"FE 81 FF 55 ...\", or line = \"...\" for a line of text");
  if (line && section.find("hex")) section.problem("hex or line: a vector has one of these");
  if (!line) return;
  vector.bytes = *line;
  if (line->ends_with('\n') || line->ends_with('\r')) return;
  for (const FrameLayout& layout : draft.codec.frames)
    if (layout.text && line->starts_with(layout.sync)) {
      vector.bytes += layout.end;
      return;
    }
}

void read_vector(const toml::table& table, const std::string& variants, Draft& draft) {
  Section section(table, "[[vector]]", draft.problems);
  FrameVector vector;
  vector.place = draft.problems.where(table.source());
  vector.source = section.text("source").value_or("");
  if (const auto* node = section.find("made_by_hand")) vector.made_by_hand = node->value_or(false);
  vector.variant = section.text("variant").value_or("");
  if (vector.source.empty() && !vector.made_by_hand) section.missing("source", "\"manual, page 12\"");
  read_vector_bytes(section, vector, draft);
  if (const auto counter = section.integer("counter")) vector.counter = static_cast<std::uint64_t>(*counter);
  if (const auto* node = section.find("time"))
    vector.time = stated_value(section, "time", *node, Unit::parse("s"), false);
  if (vector.variant == variants) read_vector_values(section, vector, draft);
  section.find("values");
  section.close();
  draft.codec.vectors.push_back(vector);
}

void require_uses(Draft& draft) {
  if (draft.codec.frames.empty()) draft.problems.all.push_back(in_file(draft.problems.file, "there is no [[frame]]"));
  const auto counted = [](const FrameLayout& layout) { return layout.counter && layout.counter->lock > 0; };
  if (draft.codec.frames.size() > 1 && std::ranges::any_of(draft.codec.frames, counted))
    draft.problems.all.push_back(
        in_file(draft.problems.file, "a frame that is found by its counter is the only [[frame]]"));
  if (draft.codec.frames.size() > 64)
    draft.problems.all.push_back(in_file(draft.problems.file, "more than 64 [[frame]]"));
  if (!draft.codec.frames.empty() && draft.codec.channels.empty())
    draft.problems.all.push_back(in_file(draft.problems.file, "no frame has a channel"));
  if (draft.codec.vectors.empty() && draft.problems.all.empty())
    draft.problems.all.push_back(
        in_file(draft.problems.file,
                "there is no [[vector]]; give the bytes of one frame and the values that they mean, so that offsets, "
                "order and scales are tested"));
}

}  // namespace

FrameCodec read_frames(std::string_view text, const std::string& file, const std::vector<std::string>& variants) {
  const toml::table document = tables::document_of(std::string(text), file);
  Draft draft;
  draft.problems.file = file;
  Section root(document, "", draft.problems);
  FrameCodec& codec = draft.codec;
  codec.name = file;
  codec.title = root.text("title").value_or("");
  codec.source = root.text("source").value_or("");
  codec.note = root.text("note").value_or("");
  if (codec.title.empty()) root.missing("title", "\"KVH 1775 IMU\"");
  if (!document.contains("certainty")) root.missing("certainty", "\"maker\"");
  codec.certainty = declaration::certainty_at(root, FrameCertainty::uncertain);
  codec.rate = root.quantity("rate", Unit::parse("Hz")).value_or(0.0);
  if (!(codec.rate >= 0.0 && codec.rate < 1e9)) root.problem_at("rate", "must be above zero");
  draft.big = declaration::order_of(root, false);
  declaration::parse_at(root, "between",
                        [&] { codec.between = declaration::parse_hex(root.text("between").value_or("")); });
  read_link(root, draft);
  read_scales(root.table("scale"), draft);
  read_variants(root, variants, draft);
  for (const auto* table : declaration::tables_at(root, "frame")) declaration::read_layout(*table, draft);
  for (const auto* table : declaration::tables_at(root, "vector")) read_vector(*table, joined(variants, ","), draft);
  root.close();
  require_uses(draft);
  if (!draft.problems.all.empty()) throw Error(Error::Kind::bad_input, draft.problems.sorted());
  for (const auto& [scale, meaning] : draft.scales)
    if (meaning == declaration::chosen_by_variant) codec.unchosen.push_back(scale);
  std::erase_if(codec.vectors, [&](const FrameVector& vector) { return vector.variant != joined(variants, ","); });
  if (auto wrong = problems_of_vectors(codec); !wrong.empty()) throw Error(Error::Kind::bad_input, wrong);
  return codec;
}

}  // namespace tumble
