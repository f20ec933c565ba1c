#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "tumble/language/said.hpp"
#include "tumble/language/section_words.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/tasks/catalogue.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

using Json = nlohmann::ordered_json;

struct ListArguments {
  std::string kind, name;
  bool json = false;
};

/// Of a format, whether it can be written; of anything else nothing.
std::string directions(const Json& entry, const SectionWords& words) {
  if (!entry.contains("writes")) return "";
  return words(entry["writes"].get<bool>() ? "writes" : "reads");
}

/// One line an entry.
std::string lines(const Json& entries, const SectionWords& words) {
  std::size_t width = 0;
  for (const auto& entry : entries) width = std::max(width, entry["name"].get_ref<const std::string&>().size());
  std::string text;
  for (const auto& entry : entries)
    text += fmt::format("  {:<{}}  {}{}\n", entry["name"].get<std::string>(), width,
                        entry["summary"].get<std::string>(), directions(entry, words));
  return text.empty() ? "  " + words("none") + "\n" : text;
}

std::string range_of(const Json& option, Language language) {
  Range range;
  range.least = option.value("min", range.least), range.least_open = option.value("min_excluded", false);
  range.most = option.value("max", range.most), range.most_open = option.value("max_excluded", false);
  return in_language(language, said_of(range, "1"));  // the unit stands before it
}

/// What may follow the name of an option: its values or unit, its range and its default.
std::string accepted(const Json& option, Language language) {
  std::string text = option["type"];
  if (option.contains("words"))
    text = fmt::format("{}", fmt::join(option["words"].get<std::vector<std::string>>(), "|"));
  if (option.contains("unit")) text = "[" + option["unit"].get<std::string>() + "]";
  if (const std::string range = range_of(option, language); !range.empty()) text += " " + range;
  return option["default"].is_null() ? text : text + " = " + option["default"].get<std::string>();
}

/// "heading:" and one item a line, its description below where both do not fit.
template <class Said>
std::string items(const Json& entry, const char* list, const std::string& heading, std::size_t width,
                  const Said& said) {
  if (!entry.contains(list) || entry[list].empty()) return "";
  std::string text = "\n" + heading + "\n";
  for (const auto& item : entry[list])
    text += fmt::format("  {}  {}\n{}", item["name"].get<std::string>(), said(item),
                        item["description"] == "" ? "" : wrapped("      ", item["description"], width));
  return text;
}

/// "takes position, rate; gives state (uncertain)"
std::string values_of_command(const Json& command) {
  const auto list = [&](const char* word) {
    const auto names = command[word].get<std::vector<std::string>>();
    return names.empty() ? "" : fmt::format("{} {}", word, fmt::join(names, ", "));
  };
  const std::string takes = list("takes"), gives = list("gives");
  const std::string both = takes + (takes.empty() || gives.empty() ? "" : "; ") + gives;
  return fmt::format("{}{}({})", both, both.empty() ? "" : " ", command["certainty"].get<std::string>());
}

/// "key: value" on lines of their own, for what the entry has.
std::string facts(const Json& entry, const SectionWords& words, std::size_t width) {
  const auto joined = [&](const char* key) {
    return fmt::format("{}", fmt::join(entry[key].get<std::vector<std::string>>(), words("comma")));
  };
  const auto has = [&](const char* key) { return entry.contains(key) && !entry[key].empty() && entry[key] != ""; };
  const auto line = [&](const char* key) { return words(key) + entry[key].get<std::string>() + "\n"; };
  std::string text;
  if (entry.contains("source")) text += wrapped(words("source"), entry["source"], width);
  if (entry.contains("certainty")) text += line("certainty");
  if (has("note")) text += wrapped(words("note"), entry["note"], width);
  if (has("variants")) text += wrapped(words("variants"), joined("variants"), width);
  if (entry.contains("method") && !entry["method"].is_null()) text += line("method");
  if (has("with_prefixes")) text += words("also") + joined("with_prefixes") + "\n";
  if (entry.contains("extensions"))
    text += words.with("extensions", joined("extensions"), directions(entry, words)) + "\n";
  for (const char* key : {"formula", "units", "frame"})
    if (entry.contains(key)) text += wrapped(words(key), entry[key], width);
  for (const char* key : {"carries", "estimates", "told_by"})
    if (has(key)) text += wrapped(words(key), joined(key), width);
  if (entry.contains("needs_plan") && entry["needs_plan"].get<bool>()) text += words("needs_plan") + "\n";
  return text;
}

/// All that one entry says of itself.
std::string page(const Json& entry, const SectionWords& words, std::size_t width) {
  const auto colon = [&](const char* key) { return words(key) + words("colon"); };
  std::string text = fmt::format("{}: {}\n", entry["name"].get<std::string>(), entry["summary"].get<std::string>());
  text += facts(entry, words, width);
  text += items(entry, "roles", colon("channels"), width, [&](const Json& role) {
    return fmt::format("[{}]{}", role["unit"].get<std::string>(),
                       role["required"].get<bool>() ? "" : words("optional"));
  });
  text += items(entry, "channels", colon("channels"), width,
                [](const Json& channel) { return fmt::format("[{}]", channel["unit"].get<std::string>()); });
  if (entry.contains("link")) text += words("link") + entry["link"].get<std::string>() + "\n";
  if (entry.contains("lost_link") && entry["lost_link"] != "")
    text += wrapped(words("lost_link"), entry["lost_link"], width);
  text += items(entry, "settings", colon("settings"), width,
                [](const Json& setting) { return "= " + setting["default"].get<std::string>(); });
  text += items(entry, "commands", colon("commands"), width, values_of_command);
  text += items(entry, "axes", colon("axes"), width, [](const Json& axis) {
    return fmt::format("[{}] {}", axis["unit"].get<std::string>(),
                       fmt::join(axis["motions"].get<std::vector<std::string>>(), "|"));
  });
  return text + items(entry, "options", colon("options"), width,
                      [&](const Json& option) { return accepted(option, words.language); });
}

const Json& find(const Json& entries, const std::string& kind, const std::string& name) {
  std::vector<std::string> known;
  for (const auto& entry : entries) {
    known.push_back(entry["name"]);
    if (known.back() == name) return entry;
    const auto prefixed = entry.value("with_prefixes", std::vector<std::string>());
    if (std::ranges::find(prefixed, name) != prefixed.end()) return entry;
  }
  throw Error(Error::Kind::unsupported, say("{}{} (known: {})", say("there is no '{}' among the {}", name, Name{kind}),
                                            did_you_mean(name, known), fmt::join(known, ", ")));
}

int run(const ListArguments& arguments, const Terminal& terminal) {
  const SectionWords words{terminal.language, "list"};
  const Language language = arguments.json ? Language::english : terminal.language;
  const auto& kinds = catalogue_kinds();
  if (arguments.kind.empty()) {
    Json all;
    std::string text;
    for (const auto& kind : kinds) {
      all[kind] = Json::parse(catalogue_json(kind, language));
      text += fmt::format("{}{}:\n{}", text.empty() ? "" : "\n", kind, lines(all[kind], words));
    }
    print(arguments.json ? all.dump(2) + "\n" : text);
    return 0;
  }
  if (std::find(kinds.begin(), kinds.end(), arguments.kind) == kinds.end())
    throw Error(Error::Kind::bad_input, say("there is no list of '{}'{} (lists: {})", arguments.kind,
                                            did_you_mean(arguments.kind, kinds), fmt::join(kinds, ", ")));
  const auto entries = Json::parse(catalogue_json(arguments.kind, language));
  if (arguments.name.empty()) {
    print(arguments.json ? entries.dump(2) + "\n" : lines(entries, words));
    return 0;
  }
  const bool own = arguments.kind == "controllers" && std::filesystem::path(arguments.name).extension() == ".toml";
  const auto entry = own ? Json::parse(controller_json(arguments.name)) : find(entries, arguments.kind, arguments.name);
  print(arguments.json ? entry.dump(2) + "\n" : page(entry, words, terminal.width));
  return 0;
}

}  // namespace

Verb list_verb() {
  auto arguments = std::make_shared<ListArguments>();
  return {"list",
          "List methods, models, rigs, formats, checks, departures, exports, plans, instruments, controllers, units",
          {{"KIND", &arguments->kind,
            "methods, models, rigs, formats, checks, departures, exports, plans, instruments, controllers or units "
            "(default: all)"},
           {"NAME", &arguments->name,
            "name of one entry, to show its options and sources; of controllers also a file of your own, to check it"},
           {"--json", &arguments->json, "print JSON, including the options"}},
          "Examples:\n"
          "  tumble list\n"
          "  tumble list methods allan_noise\n"
          "  tumble list units\n"
          "  tumble list methods --json | jq '.[].options[].name'\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
