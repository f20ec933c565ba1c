#include "unit_option.hpp"

#include "tumble/language/say.hpp"
#include "tumble/tasks/identity.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::cli {

Sets sets_of_unit(const std::string& text) {
  if (text.empty()) return {};
  const auto unit = key_and_value(text);
  if (!unit) return {{serial_key, text}};
  if (unit->first.empty() || unit->second.empty())
    throw Error(Error::Kind::bad_input,
                say("--unit {}: write SERIAL or SLOT=SERIAL, for example --unit a=0173", Name{text}));
  return {{slot_key, unit->first}, {serial_key, unit->second}};
}

std::string serial_of_unit(const std::string& text) {
  for (const auto& [key, value] : sets_of_unit(text))
    if (key == std::string(serial_key)) return value;
  return "";
}

}  // namespace tumble::cli
