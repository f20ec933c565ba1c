#include <fmt/format.h>
#include <toml++/toml.h>

#include "tumble/core/texts.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace assets {
extern const std::string_view en_toml;
extern const std::string_view zh_toml;
}  // namespace assets

namespace {

const toml::table& english_table() {
  static const toml::table table = toml::parse(assets::en_toml, std::string_view("text/en.toml"));
  return table;
}

const toml::table& chinese_table() {
  static const toml::table table = toml::parse(assets::zh_toml, std::string_view("text/zh.toml"));
  return table;
}

const toml::table& table_of(Language language) {
  return language == Language::english ? english_table() : chinese_table();
}

[[noreturn]] void refuse_key(std::string_view language, std::string_view section, std::string_view key) {
  throw Error(Error::Kind::internal,
              say("text/{}.toml has no {}.{}", std::string(language), std::string(section), std::string(key)));
}

}  // namespace

const std::vector<std::string>& language_codes() {
  static const std::vector<std::string> codes{"en", "zh"};
  return codes;
}

std::string code_of(Language language) { return language_codes()[static_cast<std::size_t>(language)]; }

std::string text_of(std::string_view section, std::string_view key, std::size_t count) {
  return text_of(Language::english, section, key, count);
}

std::string text_of(Language language, std::string_view section, std::string_view key, std::size_t count) {
  const auto entry = table_of(language)[section][key];
  const auto chosen = entry.is_table() ? entry[count == 1 ? "one" : "other"] : entry;
  if (const auto found = chosen.value<std::string>()) return *found;
  refuse_key(code_of(language), section, key);
}

std::optional<std::string> find_text(Language language, std::string_view section, std::string_view key) {
  const auto table = table_of(language).at_path(section);
  return table.is_table() ? table[key].value<std::string>() : std::nullopt;
}

std::map<std::string, std::string> texts_of(Language language, std::string_view section) {
  const auto* table = table_of(language)[section].as_table();
  if (!table) refuse_key(code_of(language), section, "");
  std::map<std::string, std::string> texts;
  for (const auto& [key, value] : *table)
    if (const auto text = value.value<std::string>())
      texts.emplace(key.str(), *text);
    else if (const auto* forms = value.as_table())
      for (const auto& [form, words] : *forms)
        texts.emplace(fmt::format("{}.{}", key.str(), form.str()), words.value_or(std::string()));
  return texts;
}

}  // namespace tumble
