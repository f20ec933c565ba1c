#include "tumble/core/text.hpp"

#include <toml++/toml.h>

#include "tumble/units/error.hpp"

namespace tumble {

namespace assets {
extern const std::string_view en_toml;
}

std::string text_of(std::string_view section, std::string_view key, std::size_t count) {
  static const toml::table english = toml::parse(assets::en_toml, std::string_view("text/en.toml"));
  const auto entry = english[section][key];
  const auto chosen = entry.is_table() ? entry[count == 1 ? "one" : "other"] : entry;
  if (const auto found = chosen.value<std::string>()) return *found;
  throw Error(Error::Kind::internal, "text/en.toml has no " + std::string(section) + "." + std::string(key));
}

}  // namespace tumble
