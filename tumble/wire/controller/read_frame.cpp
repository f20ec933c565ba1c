#include <fmt/format.h>

#include <algorithm>

#include "tumble/wire/codec/checksum.hpp"
#include "tumble/wire/controller/declared.hpp"
#include "tumble/wire/controller/template.hpp"
#include "tumble/wire/controller/words.hpp"

namespace tumble::controller {

namespace {

using declaration::bytes_at;
using declaration::parse_at;
using tables::Section;

ControllerFraming framing_of(Section& around, const char* key, Declared& declared) {
  ControllerFraming framing;
  const auto* table = around.table(key);
  if (!table) {
    around.missing(key, "{tail = \"\\r\\n\"}");
    return framing;
  }
  Section section = declared.draft.section(*table, key);
  framing.head = bytes_at(section, "head");
  parse_at(section, "tail", [&] {
    for (const auto& tail : section.texts("tail")) framing.tail.push_back(latin1(tail));
  });
  if (std::ranges::any_of(framing.tail, &std::string::empty)) section.problem_at("tail", "an empty text marks no end");
  if (framing.tail.empty() && framing.head.empty()) section.missing("tail", "\"\\r\\n\"");
  section.close();
  return framing;
}

/// The checksum that a word of a declaration means; nothing where it is no such word, no sum where it is "none".
std::optional<ControllerChecksum> checksum_named(std::string_view kind) {
  using Kind = FrameChecksum::Kind;
  using Form = ControllerChecksum::Form;
  if (kind == "none") return ControllerChecksum{};
  if (kind == "crc16") return modbus_checksum();
  struct Known {
    std::string_view name;
    Kind kind;
    Form form;
  };
  constexpr Known all[] = {
      {"sum_hex", Kind::sum, Form::digits},           {"xor_hex", Kind::exclusive_or, Form::digits},
      {"nmea_xor", Kind::exclusive_or, Form::digits}, {"sum", Kind::sum, Form::bytes},
      {"xor", Kind::exclusive_or, Form::bytes},       {"xor_bit7", Kind::exclusive_or, Form::bit7}};
  const auto* const found = std::ranges::find(all, kind, &Known::name);
  if (found == std::end(all)) return std::nullopt;
  return ControllerChecksum{.sum = FrameChecksum{.kind = found->kind}, .form = found->form};
}

ControllerChecksum checksum_at(Section& around, Declared& declared) {
  const auto* table = around.table("checksum");
  if (!table) return {};
  Section section = declared.draft.section(*table, "checksum");
  const auto known = checksum_named(section.text("kind").value_or(""));
  if (!known) section.problem_at("kind", "sum_hex, nmea_xor, sum, xor, xor_bit7, crc16 or none is expected");
  ControllerChecksum check = known.value_or(ControllerChecksum{});
  const std::string mark = bytes_at(section, "mark");
  if (check.sum) check.sum->before = mark;
  check.with_head = flag_at(section, "with_head", false);
  section.close();
  return check;
}

ControllerBitRule rule_of(const toml::table& table, Declared& declared) {
  Section section = declared.draft.section(table, "rules");
  ControllerBitRule rule;
  const auto whole = [&](const char* key, std::uint32_t otherwise) -> std::uint32_t {
    const auto* node = section.find(key);
    if (!node) return otherwise;
    const auto* value = node->as_integer();
    if (value && value->get() >= 0 && value->get() <= 4294967295) return static_cast<std::uint32_t>(value->get());
    section.problem_at(key, "a whole number of 32 bits is expected");
    return otherwise;
  };
  const std::uint32_t bit = whole("bit", 32);
  if (bit < 32) {
    rule.mask = std::uint32_t{1} << bit;
    const std::uint32_t equals = whole("equals", 1);
    rule.equals = equals << bit;
    if (equals > 1) section.problem_at("equals", "of one bit, 0 or 1 is expected");
  } else {
    const bool any = !table.contains("mask") && !table.contains("equals");
    rule.mask = any ? 0 : whole("mask", 0xffffffffu);
    rule.equals = any ? 0 : whole("equals", 0);
    if ((rule.equals & ~rule.mask) != 0) section.problem_at("equals", "has bits that are not in the mask");
  }
  section.find("mask");
  rule.means = section.text("means").value_or("");
  if (rule.means.empty()) section.missing("means", "\"ready\"");
  section.close();
  return rule;
}

void read_bits(Section& root, Declared& declared) {
  const auto* all = root.table("bits");
  if (!all) return;
  for (const auto& [key, node] : *all) {
    const auto* table = node.as_table();
    if (!table) {
      root.problem_at("bits", "a table for each word is expected, [bits.state]");
      continue;
    }
    Section section = declared.draft.section(*table, fmt::format("[bits.{}]", key.str()));
    ControllerBits bits{std::string(key.str()), section.text("from").value_or(""), {}};
    if (bits.from.empty()) section.missing("from", "\"status\"");
    for (const auto* rule : declaration::tables_at(section, "rules")) bits.rules.push_back(rule_of(*rule, declared));
    for (const auto& rule : bits.rules)
      if (!rule.means.empty() && !bits_of_word(bits, rule.means))
        section.problem_at("rules", say("no number means '{}': the rules before it hold for all of them", rule.means));
    section.close();
    declared.controller.bits.push_back(bits);
  }
}

ControllerSaying saying_of(const toml::table& table, const char* name, Declared& declared) {
  Section section = declared.draft.section(table, name);
  ControllerSaying saying;
  const auto text = section.text("expect");
  if (!text) section.missing("expect", "\"error:{code=20}\"");
  parse_at(section, "expect", [&] { saying.expect = parse_template(text.value_or("")); });
  for (const auto& piece : saying.expect.pieces)
    if (piece.kind == ControllerPiece::Kind::number && !piece.otherwise)
      section.problem_at("expect",
                         say("the number '{}' needs a default, {}", piece.text, Name{"{" + piece.text + ":d=1}"}));
  if (const auto* meanings = section.table("meaning"))
    for (const auto& [key, node] : *meanings)
      if (const auto meaning = tables::text_of(node)) saying.meaning[std::string(key.str())] = *meaning;
  saying.state = section.text("state").value_or("");
  section.close();
  return saying;
}

}  // namespace

ControllerChecksum modbus_checksum() {
  FrameChecksum crc{.kind = FrameChecksum::Kind::crc, .width = 16, .poly = 0x8005, .init = 0xffff, .reflected = true};
  crc.table = codec::crc_table(crc);
  return {.sum = crc, .form = ControllerChecksum::Form::bytes, .with_head = true};
}

void read_frame(Section& root, Declared& declared) {
  Controller& controller = declared.controller;
  const auto* table = root.table("framing");
  if (controller.protocol != Controller::Protocol::text) {
    if (table) root.problem_at("framing", "Modbus and HTTP have their own");
    return;
  }
  if (!table) return root.missing("framing", "send = {tail = \"\\r\\n\"}, reply = {tail = \"\\r\\n\"}");
  Section section = declared.draft.section(*table, "[framing]");
  controller.send = framing_of(section, "send", declared);
  controller.reply = framing_of(section, "reply", declared);
  controller.checksum = checksum_at(section, declared);
  controller.bit7 = flag_at(section, "bit7", false);
  controller.trim = flag_at(section, "trim", !controller.bit7 && !controller.send.tail.empty());
  controller.skip = number_at(section, "skip", 256).value_or(0);
  controller.longest = static_cast<std::size_t>(number_at(section, "longest", 65536).value_or(1024));
  const std::string echo = section.text("echo").value_or("never");
  using Echo = Controller::Echo;
  controller.echo = echo == "always" ? Echo::always : echo == "maybe" ? Echo::maybe : Echo::never;
  if (controller.echo == Echo::never && echo != "never")
    section.problem_at("echo", "never, maybe or always is expected");
  section.close();
}

void read_words(Section& root, Declared& declared) {
  if (const auto* all = root.table("word"))
    for (const auto& [key, node] : *all) {
      const auto* table = node.as_table();
      if (!table) {
        root.problem_at("word", "a table for each word is expected, [word.state]");
        continue;
      }
      std::vector<std::tuple<unsigned, unsigned, std::string, std::string>> lines;
      Section section = declared.draft.section(*table, fmt::format("[word.{}]", key.str()));
      for (const auto& [text, meaning] : *table)
        parse_at(section, text.str(), [&] {
          const auto place = meaning.source().begin;
          lines.emplace_back(place.line, place.column, latin1(text.str()), section.text(text.str()).value_or(""));
        });
      std::ranges::sort(lines);
      auto& words = declared.controller.words[std::string(key.str())];
      for (const auto& [line, column, text, meaning] : lines) words.emplace_back(text, meaning);
    }
  read_bits(root, declared);
}

void read_sayings(Section& root, Declared& declared) {
  for (const auto* table : declaration::tables_at(root, "error"))
    declared.controller.errors.push_back(saying_of(*table, "[[error]]", declared));
  for (const auto* table : declaration::tables_at(root, "notice"))
    declared.controller.notices.push_back(saying_of(*table, "[[notice]]", declared));
}

}  // namespace tumble::controller
