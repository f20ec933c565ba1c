#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/wire/controller.hpp"

namespace tumble::controller {

/// Bytes of a text of the declaration: every character is one byte, "¶" is B6. Throws Error::bad_input for a character
/// above U+00FF.
std::string latin1(std::string_view utf8);

/// Bytes for a message: what is not printable as <0D>.
std::string shown(std::string_view bytes);

/// A template from a text of the declaration: "POS {axis},{position:.4f deg}". Throws Error::bad_input.
ControllerTemplate parse_template(std::string_view text);

/// A field from what stands in its braces: "position.2:.4f deg=0". Throws Error::bad_input.
ControllerPiece parse_field(std::string_view text);

/// Values of the fields of a template, in one direction or the other. Words are as the device writes them.
struct Content {
  std::map<std::string, double> values;  ///< [SI]
  std::map<std::string, std::string> words;
  std::optional<int> axis;
};

/// The bytes of the template. Values of fields with an axis are looked up as "position.2", and as "position" where the
/// axis is that of `content`. Throws Error::bad_input where a value is missing or does not fit.
std::string fill(const ControllerTemplate& form, const Content& content, const std::vector<std::string>& axes);

/// The fields, if the bytes are of this template.
std::optional<Content> match(const ControllerTemplate& form, std::string_view bytes,
                             const std::vector<std::string>& axes);

/// [byte] of everything that fits the template; absent where its fields have no fixed size.
std::optional<std::size_t> size_of(const ControllerTemplate& form);

/// "position.2"
std::string key_of(const ControllerPiece& piece);

/// A number [SI] as the line has it. Throws Error::bad_input where it does not fit.
std::string write_number(const ControllerPiece& piece, double si);

/// The number [SI] at the begin of `bytes`, which it is removed from; absent if they begin otherwise.
std::optional<double> take_number(const ControllerPiece& piece, std::string_view& bytes);

/// [SI] half a step of the format at a value.
double resolution(const ControllerPiece& piece, double si);

/// Value [SI] of a default.
double value_of_default(const ControllerPiece& piece);

}  // namespace tumble::controller
