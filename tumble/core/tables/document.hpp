#pragma once

#include <toml++/toml.h>

#include <string>

namespace tumble::tables {

/// The tables of a text in TOML.
///
/// Given     text   in TOML
///           file   its name, for messages
///
/// Returned  the tables, with the lines where they stand
///
/// Throws    Error::bad_input, with line and column, where the text is not TOML
toml::table document_of(const std::string& text, const std::string& file);

}  // namespace tumble::tables
