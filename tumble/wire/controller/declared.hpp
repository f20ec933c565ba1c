#pragma once

#include <toml++/toml.h>

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "tumble/core/tables/section.hpp"
#include "tumble/wire/controller.hpp"
#include "tumble/wire/declaration/draft.hpp"

namespace tumble::controller {

/// A declaration of a controller while it is read.
struct Declared {
  declaration::Draft draft;
  Controller controller;
  double timeout = 1.0, pause = 0.0;  ///< [s] where a command says nothing else
  bool low_word_first = false;        ///< Modbus, where a command says nothing else
};

/// A whole number, or a text that holds one.
std::optional<int> number_at(tables::Section& section, std::string_view key, int most);

bool flag_at(tables::Section& section, std::string_view key, bool otherwise);

/// [s] from "250 ms".
double seconds_at(tables::Section& section, std::string_view key, double otherwise);

/// Replaces ${name} in every text of the document by a setting: that of `wanted`, else the default of [setting].
void put_settings(toml::table& document, const std::map<std::string, std::string>& wanted, Declared& declared);

/// The CRC of a line of Modbus, over the address of the device too.
ControllerChecksum modbus_checksum();

void read_frame(tables::Section& root, Declared& declared);
void read_sayings(tables::Section& root, Declared& declared);
void read_words(tables::Section& root, Declared& declared);
void read_commands(tables::Section& root, Declared& declared);
void read_vectors(tables::Section& root, Declared& declared);

/// The dimension that values of this name have; null: any number without unit.
const std::vector<Unit>* units_of(const std::string& value);

/// Problems of a declaration that is read whole: verbs that are the same, words that no bits say.
void require_sense(Declared& declared);

}  // namespace tumble::controller
