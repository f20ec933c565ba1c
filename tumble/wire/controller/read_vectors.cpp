#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tumble/core/tables/section.hpp"
#include "tumble/wire/controller/declared.hpp"
#include "tumble/wire/controller/template.hpp"
#include "tumble/wire/declaration/format.hpp"

namespace tumble::controller {

namespace {

using declaration::parse_at;
using tables::Section;

std::map<std::string, double> quantities_at(Section& around, const char* key, Declared& declared,
                                            std::map<std::string, double>* tolerance) {
  std::map<std::string, double> values;
  const auto* table = around.table(key);
  if (!table) return values;
  Section section = declared.draft.section(*table, fmt::format("[[vector]] {}", key));
  for (const auto& [name_key, node] : *table) {
    const std::string name(name_key.str());
    const std::string base = name.substr(0, name.find('.'));
    const auto* units = units_of(base);
    const auto text = tables::text_of(node).value_or("");
    section.find(name);
    parse_at(section, name, [&] {
      const Quantity quantity = parse_quantity(text);
      const auto fits = [&](const Unit& unit) { return unit.dimension() == quantity.unit.dimension(); };
      if (units ? std::ranges::none_of(*units, fits) : quantity.unit.dimension() != Dimension{})
        throw Error(Error::Kind::bad_input, say("'{}' must be in {}", text,
                                                units ? say("{}", Name{units->front().text()}) : Sentence("no unit")));
      values[name] = quantity.unit.to_si(quantity.value);
      if (tolerance) (*tolerance)[name] = declaration::half_of_last_digit(text) * std::abs(quantity.unit.factor());
    });
  }
  section.close();
  return values;
}

std::vector<std::string> lines_at(Section& section, const char* key) {
  std::vector<std::string> lines;
  parse_at(section, key, [&] {
    for (const auto& text : section.texts(key)) lines.push_back(latin1(text));
  });
  return lines;
}

/// Bytes in hexadecimal, for Modbus and binary protocols: the key with _hex behind it.
void add_hex(Section& section, const char* key, std::vector<std::string>& lines) {
  parse_at(section, key, [&] {
    for (const auto& text : section.texts(key)) lines.push_back(declaration::parse_hex(text));
  });
}

void read_vector(const toml::table& table, Declared& declared) {
  Section section = declared.draft.section(table, "[[vector]]");
  ControllerVector vector;
  vector.place = declared.draft.problems.where(table.source());
  const auto verb = find_verb(section.text("verb").value_or(""));
  const auto* command = verb ? declared.controller.find(*verb) : nullptr;
  if (command) vector.request.verb = command->verb;
  if (!command) section.problem_at("verb", "one of the commands of this declaration is expected");
  vector.request.axis = section.integer("axis").value_or(1);
  vector.request.values = quantities_at(section, "values", declared, nullptr);
  vector.sends = lines_at(section, "send");
  add_hex(section, "send_hex", vector.sends);
  vector.replies = lines_at(section, "reply");
  add_hex(section, "reply_hex", vector.replies);
  vector.reply.verb = vector.request.verb;
  vector.reply.values = quantities_at(section, "gives", declared, &vector.tolerance);
  if (const auto* words = section.table("words"))
    for (const auto& [key, node] : *words)
      vector.reply.words[std::string(key.str())] = tables::text_of(node).value_or("");
  vector.reply.refused = flag_at(section, "refused", false);
  if (const auto text = section.text("text"); text && !text->empty()) vector.reply.text = say("{}", Name{*text});
  vector.host_only = flag_at(section, "host_only", false);
  vector.source = section.text("source").value_or("");
  vector.made_by_hand = flag_at(section, "made_by_hand", false);
  if (vector.source.empty() && !vector.made_by_hand) section.missing("source", "\"manual, page 12\"");
  if (vector.sends.empty()) section.missing("send", "the bytes that are sent, \"POS?\\r\\n\"");
  section.close();
  declared.controller.vectors.push_back(vector);
}

}  // namespace

void read_vectors(Section& root, Declared& declared) {
  for (const auto* table : declaration::tables_at(root, "vector")) read_vector(*table, declared);
  if (declared.controller.vectors.empty() && declared.draft.sound())
    declared.draft.add(
        "there is no [[vector]]; give the bytes of one command and of its reply, and the values that they "
        "mean, so that formats and units are tested");
}

}  // namespace tumble::controller
