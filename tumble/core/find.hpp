#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/settings.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

/// The entry called `name`, or Error::unsupported that says what there is and which is nearest. `noun` for messages.
template <class Entry>
const Entry& find_entry(const std::vector<const Entry*>& catalogue, std::string_view name, const std::string& noun) {
  std::vector<std::string> known;
  for (const auto* entry : catalogue) {
    if (name == entry->name) return *entry;
    known.emplace_back(entry->name);
  }
  Sentence said = say("'{}'{}{}", Name{std::string(name)}, did_you_mean(name, known), Name{joined(known)});
  said.values.back().names = known;
  said.pattern = "there is no " + noun + " '{}'{} (" + noun + "s: {})";
  throw Error(Error::Kind::unsupported, std::move(said));
}

}  // namespace tumble
