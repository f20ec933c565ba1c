#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/wire/codec/line.hpp"
#include "tumble/wire/codec/number.hpp"
#include "tumble/wire/declaration/declared.hpp"

namespace tumble::declaration {

namespace {

using tables::Section;

/// The cell holds letters, which should be `word`.
void become_word(Section& section, const std::string& word, FrameCondition& condition) {
  if (word.empty() || word.size() > 8) section.problem_at("equals", "a word of 1 to 8 letters is expected");
  condition.number.form = FrameNumber::Form::word;
  condition.number.bytes = 8;
  condition.number.bits = 64;
  condition.number.shift = 0;
  condition.equals = codec::word_bits(word);
}

FrameCondition condition_in(Section& section, int item, bool big, FrameLayout& layout) {
  FrameCondition condition;
  condition.number = number_of(section, big, layout.text ? "u32" : "u8", layout);
  const auto items = items_of(section, layout);
  condition.number.item = items.front() >= 0 ? items.front() : item;
  place_number(section, condition.number, layout);
  const auto* equals = section.find("equals");
  if (!equals) section.missing("equals", "1");
  if (layout.text && equals && equals->is_string())
    become_word(section, equals->value_or(std::string()), condition);
  else
    condition.equals = static_cast<std::uint64_t>(section.integer("equals").value_or(0));
  condition.modulus = static_cast<std::uint64_t>(section.integer("modulo").value_or(0));
  if (condition.number.kind != FrameNumber::Kind::natural) section.problem_at("type", "a natural number is expected");
  if (condition.equals > codec::mask_of(condition.number.bits))
    section.problem_at("equals", say("does not fit into {} bits", condition.number.bits));
  return condition;
}

/// Index of the channel of that name and scale; it is added where it is new.
std::size_t channel_index(Section& section, const std::string& name, const Scale& scale, const Unit& shown,
                          Declared& declared) {
  auto& channels = declared.codec.channels;
  const auto found = std::ranges::find(channels, name, &FrameChannel::name);
  if (found == channels.end()) {
    channels.push_back({name, shown, scale.increment});
    if (channels.size() > 500) section.problem("more than 500 channels"), channels.pop_back();
    return channels.size() - 1;
  }
  if (found->increment != scale.increment || found->unit.dimension() != shown.dimension())
    section.problem_at("scale", say("'{}' is measured in {}{} in another place", name, Name{found->unit.text()},
                                    found->increment ? ", as an increment" : ""));
  return static_cast<std::size_t>(found - channels.begin());
}

/// In which unit people see a channel of that scale.
Unit shown_unit(Section& section, const Scale& scale) {
  Unit natural = scale.unit;
  if (scale.increment) natural = Unit::parse(scale.unit.text() == "1" ? "1/s" : scale.unit.text() + "/s");
  const auto text = section.text("unit");
  if (!text) return natural;
  const Unit unit = Unit::parse(*text);
  if (unit.dimension() != natural.dimension())
    section.problem_at("unit", say("{} does not measure what {} does", Name{unit.text()}, Name{natural.text()}));
  return unit;
}

std::vector<std::string> channel_names(Section& section) {
  auto names = section.texts("name");
  if (names.empty()) section.missing("name", "\"gyro.x\"");
  for (const auto& name : names)
    if (name.empty() || name.find_first_of(" ,;\t\n\"[]") != std::string::npos)
      section.problem_at("name", say("'{}' is no name of a channel; letters, digits, . and _ are", name));
  return names;
}

void read_channel(const toml::table& table, bool big, FrameLayout& layout, Declared& declared) {
  Section section = declared.draft.section(table, "channel");
  const auto names = channel_names(section);
  FrameField field;
  field.number = number_of(section, big, layout.text ? "decimal" : "u8", layout);
  if (!section.find("type") && !layout.text) section.missing("type", "\"f32\"");
  const auto items = items_of(section, layout);
  const int size = layout.text ? layout.text->cells[static_cast<std::size_t>(items[0])].width : field.number.bytes;
  const int step = section.integer("step").value_or(std::max(size, 1));
  Scale scale;
  Unit shown;
  parse_at(section, "scale", [&] { scale = parse_scale(section.text("scale").value_or("1"), declared.scales); });
  parse_at(section, "unit", [&] { shown = shown_unit(section, scale); });
  const auto* zero = section.find("zero");
  const auto sign = whole_of(section, "sign").value_or(1);
  if (sign != 1 && sign != -1) section.problem_at("sign", "1 or -1 is expected");
  field.factor = scale.factor * scale.unit.factor() * (sign < 0 ? -1.0 : 1.0);
  field.zero = (zero ? zero->value_or(0.0) : 0.0) * scale.unit.factor() + scale.unit.offset();
  if (!std::isfinite(field.factor) || !std::isfinite(field.zero)) section.problem_at("scale", "is too large");
  if (const auto* table_when = section.table("when")) {
    Section when = declared.draft.section(*table_when, "when");
    field.when = condition_in(when, items.front(), big, layout);
    when.close();
  }
  if (names.size() > 64 || step > 512) return section.problem("more than 64 names, or a step above 512");
  for (const int item : items)
    for (std::size_t i = 0; i < names.size(); ++i) {
      FrameField one = field;
      one.number.item = layout.text ? cell_of(section, layout, static_cast<int>(i) * step) : item;
      if (!layout.text) one.number.at += static_cast<int>(i) * step;
      if (!layout.text && one.when && one.when->number.item >= 0 && item >= 0) one.when->number.item = item;
      one.channel = channel_index(section, names[i], scale, shown, declared);
      place_number(section, one.number, layout);
      layout.fields.push_back(one);
    }
  section.close();
}

}  // namespace

void read_channels(Section& section, bool big, FrameLayout& layout, Declared& declared) {
  for (const auto* table : tables_at(section, "channel")) read_channel(*table, big, layout, declared);
}

void read_statuses(Section& section, bool big, FrameLayout& layout, Declared& declared) {
  for (const auto* table : tables_at(section, "status")) {
    Section status = declared.draft.section(*table, "status");
    FrameStatus read;
    read.good = condition_in(status, -1, big, layout);
    read.text = status.text("text").value_or("");
    const auto means = status.text("means").value_or("fail");
    if (means != "fail" && means != "warning") status.problem_at("means", "\"fail\" or \"warning\" is expected");
    read.fails = means == "fail";
    const auto wanted = status.texts("channels");
    for (const FrameField& field : layout.fields) {
      const std::string& name = declared.codec.channels[field.channel].name;
      const auto meant = [&](const std::string& one) { return name == one || name.starts_with(one + "."); };
      if ((wanted.empty() || std::ranges::any_of(wanted, meant)) &&
          std::ranges::find(read.channels, field.channel) == read.channels.end())
        read.channels.push_back(field.channel);
    }
    if (!wanted.empty() && read.channels.empty()) status.problem_at("channels", "the frame has no such channel");
    status.close();
    if (layout.statuses.size() == 60) return section.problem("more than 60 statuses in one frame");
    layout.statuses.push_back(read);
  }
}

void read_counter(Section& around, bool big, FrameLayout& layout, Declared& declared) {
  const auto* table = around.table("counter");
  if (!table) return;
  Section section = declared.draft.section(*table, "counter");
  FrameCounter counter;
  counter.number = number_of(section, big, "u8", layout);
  counter.number.item = items_of(section, layout).front();
  place_number(section, counter.number, layout);
  if (counter.number.kind != FrameNumber::Kind::natural || counter.number.bits > 32)
    section.problem_at("type", "a natural number of up to 32 bits is expected");
  const std::uint64_t most = std::uint64_t{1} << std::min(counter.number.bits, 32);
  counter.modulus = static_cast<std::uint64_t>(whole_of(section, "modulus").value_or(static_cast<long long>(most)));
  if (counter.modulus < 2 || counter.modulus > most) {
    section.problem_at("modulus", say("2 to {} is expected", most));
    counter.modulus = most;
  }
  if (const auto* step = section.find("step"); step && step->is_string() && step->value_or(std::string()) == "any")
    counter.step = 0;
  else if (const auto given = section.integer("step"); given && *given > 0)
    counter.step = static_cast<std::uint64_t>(*given);
  else if (step)
    section.problem_at("step", "a whole number above 0, or \"any\", is expected");
  if (counter.step >= counter.modulus) section.problem_at("step", "must be below the modulus");
  section.close();
  layout.counter = counter;
}

void read_time(Section& around, bool big, FrameLayout& layout, Declared& declared) {
  const auto tables = tables_at(around, "time");
  if (!tables.empty()) layout.time.clear();
  for (const auto* table : tables) {
    Section section = declared.draft.section(*table, "time");
    FrameTime part;
    part.number = number_of(section, big, layout.text ? "decimal" : "u32", layout);
    part.number.item = items_of(section, layout).front();
    place_number(section, part.number, layout);
    if (!section.find("scale")) section.missing("scale", "\"1 us\"");
    parse_at(section, "scale", [&] {
      const Scale scale = parse_scale(section.text("scale").value_or("1 s"), declared.scales);
      if (scale.unit.dimension() != Unit::parse("s").dimension() || scale.increment || scale.factor < 0.0)
        throw Error(Error::Kind::bad_input, "a unit of time is expected, for example \"1 us\"");
      part.factor = scale.factor * scale.unit.factor();
    });
    const bool whole = part.number.kind == FrameNumber::Kind::natural;
    const auto* otherwise = section.find("otherwise");
    if (!layout.time.empty())
      part.choice = layout.time.back().choice + (otherwise && otherwise->value_or(false) ? 1 : 0);
    const bool leads = layout.time.empty() || part.choice != layout.time.back().choice;
    part.wrap = whole && leads ? std::ldexp(part.factor, part.number.bits) : 0.0;
    if (const auto wrap = section.quantity("wrap", Unit::parse("s"))) part.wrap = *wrap;
    if (!(part.wrap >= 0.0)) section.problem_at("wrap", "must be above zero");
    section.close();
    layout.time.push_back(part);
  }
}

}  // namespace tumble::declaration
