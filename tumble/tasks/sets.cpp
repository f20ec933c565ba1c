#include "tumble/tasks/sets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "tumble/tasks/identity.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

/// [Hz], from "100" or "100 Hz".
double parse_rate(const std::string& text) {
  const auto quantity = parse_quantity(text);
  const double rate = quantity.bare ? quantity.value : parse_si(text, Unit::parse("Hz"));
  if (!(rate > 0.0)) throw Error(Error::Kind::bad_input, "the rate must be above zero");
  return rate;
}

/// What follows `prefix` in `key`, or empty.
std::string_view after(std::string_view key, std::string_view prefix) {
  return key.size() > prefix.size() && key.substr(0, prefix.size()) == prefix ? key.substr(prefix.size())
                                                                              : std::string_view();
}

/// "time[s], gyro[deg/s]"
std::vector<std::string> separate(const std::string& text) {
  auto parts = list_items(text);
  if (std::ranges::find(parts, "") != parts.end())
    throw Error(Error::Kind::bad_input, "a column has no name; write - for a column to skip");
  return parts;
}

/// How a file is read, by the keys that say it.
using ReadingSetter = void (*)(ReadOptions&, const std::string& value);
constexpr std::pair<std::string_view, ReadingSetter> reading_keys[] = {
    {"rate", [](auto& reading, const auto& value) { reading.rate = parse_rate(value); }},
    {"missing", [](auto& reading, const auto& value) { reading.missing = value; }},
    {"columns", [](auto& reading, const auto& value) { reading.columns = separate(value); }},
    {"topic", [](auto& reading, const auto& value) { reading.topics.push_back(value); }},
    {"frames", [](auto& reading, const auto& value) { reading.frames = value; }},
    {"segment_column", [](auto& reading, const auto& value) { reading.segment_column = value; }},
    {"decimal", [](auto& reading, const auto& value) { reading.decimal = parse_decimal(value); }},
    {"time", [](auto& reading, const auto& value) { reading.time = value; }},
    {"date", [](auto& reading, const auto& value) { reading.date = parse_date_order(value); }},
    {"encoding", [](auto& reading, const auto& value) { reading.encoding = value; }},
    {"skip", [](auto& reading, const auto& value) { reading.skip = parse_skip(value); }}};

ReadingSetter find_reading(std::string_view key) {
  const auto found = std::ranges::find(reading_keys, key, &std::pair<std::string_view, ReadingSetter>::first);
  return found == std::end(reading_keys) ? nullptr : found->second;
}

bool for_reading(const std::string& key) { return find_reading(key) != nullptr || !after(key, "unit.").empty(); }

std::string not_empty(const std::string& text) {
  if (text.empty()) throw Error(Error::Kind::bad_input, "a text is expected, not an empty one");
  return text;
}

void sort_in(SortedSets& sorted, const std::string& key, const std::string& value) {
  const Given given{key, value, "--set", true, true};
  const auto renamed = [&](std::string_view name) {
    Given copy = given;
    copy.key = name;
    return copy;
  };
  if (const auto set = find_reading(key)) set(sorted.reading, value);
  if (key == serial_key || key == slot_key)
    (key == serial_key ? sorted.serial : sorted.slot) = not_empty(value);
  else if (key == "calibration")
    sorted.calibration = value;
  else if (key == "prior")
    sorted.prior = value;
  else if (const auto column = after(key, "unit."); !column.empty())
    sorted.reading.units[std::string(column)] = Unit::parse(value);
  else if (const auto role = after(key, "channels."); !role.empty())
    sorted.channels.emplace_back(role, value);
  else if (const auto truth = after(key, "truth."); !truth.empty())
    sorted.truth.push_back(renamed(truth));
  else if (const auto rig = after(key, "rig."); !rig.empty())
    sorted.rig.push_back(renamed(rig));
  else if (const auto beside = after(key, "beside."); !beside.empty())
    sorted.beside.push_back(renamed(beside));
  else if (key == "rate" || find_reading(key) == nullptr)  // a rate is a setting of some methods, too
    sorted.settings.push_back(given);
}

}  // namespace

SortedSets sorted(const Sets& sets) {
  SortedSets result;
  Problems problems;
  for (const auto& [key, value] : sets) try {
      sort_in(result, key, value);
    } catch (const Error& error) {
      for (const auto& problem : error.problems)
        problems.push_back(within(Where{.key = key, .place = say("--set {}={}", Name{key}, Name{value})}, problem));
    }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return result;
}

ReadOptions read_options(const Sets& sets) {
  Problems problems;
  Sets known;
  for (const auto& set : sets)
    if (for_reading(set.first))
      known.push_back(set);
    else
      problems.push_back(
          say("--set {}: reading a file takes rate, missing, columns, segment_column, decimal, time, date, encoding, "
              "skip, topic, frames and unit.<column>",
              Name{set.first}));
  try {
    const auto reading = sorted(known).reading;
    if (problems.empty()) return reading;
  } catch (const Error& error) {
    problems.insert(problems.end(), error.problems.begin(), error.problems.end());
  }
  throw Error(Error::Kind::bad_input, problems);
}

char parse_decimal(const std::string& text) {
  if (text != "comma" && text != "point")
    throw Error(Error::Kind::bad_input, say("the decimal mark is comma or point, not '{}'", text));
  return text == "comma" ? ',' : '.';
}

std::string parse_date_order(const std::string& text) {
  if (text != "dmy" && text != "mdy" && text != "ymd")
    throw Error(Error::Kind::bad_input, say("the order of a date is dmy (day first), mdy or ymd, not '{}'", text));
  return text;
}

std::size_t parse_skip(const std::string& text) {
  const auto lines = as_number<std::size_t>(text);
  if (!lines || *lines > 100'000)
    throw Error(Error::Kind::bad_input, say("a number of lines up to 100000 is expected, not '{}'", text));
  return *lines;
}

ChannelChoice parse_choice(const std::string& text) {
  const auto open = text.find('[');
  if (open == std::string::npos) return {text, std::nullopt};
  if (open == 0 || text.back() != ']')
    throw Error(Error::Kind::bad_input, say("\"{}\" is no channel; write \"name\" or \"name[unit]\"", text));
  return {text.substr(0, open), Unit::parse(text.substr(open + 1, text.size() - open - 2))};
}

std::vector<ChannelChoice> parse_choices(const std::string& text) {
  std::vector<ChannelChoice> choices;
  for (const std::string& item : list_items(text)) {
    if (item.empty()) throw Error(Error::Kind::bad_input, say("\"{}\" lacks a channel; write \"S1, S2\"", text));
    choices.push_back(parse_choice(item));
  }
  return choices;
}

std::string listed(const std::vector<ChannelChoice>& choices) {
  std::string names;
  for (const auto& choice : choices) names += (names.empty() ? "" : ", ") + choice.channel;
  return names;
}

std::vector<Given> overridden(std::vector<Given> from_file, const std::vector<Given>& from_command_line) {
  for (const auto& given : from_command_line) {
    std::erase_if(from_file, [&](const Given& old) { return old.key == given.key; });
    from_file.push_back(given);
  }
  return from_file;
}

}  // namespace tumble
