#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/formats/topics/damage.hpp"
#include "tumble/formats/topics/topic.hpp"

namespace tumble::dataflash {

using topics::Damage;

constexpr std::string_view magic = "\xa3\x95";
constexpr std::size_t message_head = 3;  ///< magic, u8 id

/// A field of a message.
struct Field {
  std::string label;
  char type = 0;           ///< as FMT has it
  std::size_t offset = 0;  ///< [bytes] from the beginning of the message
};

/// Description of the messages of one id, by FMT.
struct Description {
  std::string name;           ///< empty: there is no FMT
  std::size_t length = 0;     ///< [bytes] of a message
  std::vector<Field> fields;  ///< none where a type is not known, or they do not fit into the length
  bool ambiguous = false;     ///< two FMT contradict each other: the messages cannot be read
};
using Descriptions = std::array<Description, 256>;

/// Bytes of a type of FMT; 0: it is not known.
std::size_t size_of(char type);
/// The number of this type; nothing for text, arrays and half floats.
std::optional<topics::Number> number_of(char type);
/// The field of that label, or null.
const Field* find_field(const Description& description, std::string_view label);
/// Text of a field, printable; empty: no such field.
std::string text_of(const Description& description, const char* message, std::string_view label);
/// Number of a field [as written]; nothing without such a field.
std::optional<double> value_of(const Description& description, const char* message, std::string_view label);

/// The stamp of a message: when the sample was taken, where the message says it. Null where it has none.
const Field* time_field(const Description& description);
/// Counts of this stamp in a second [1/s].
double ticks_of(const Field& time);
/// [s] on the clock of the autopilot; nothing where the message has no stamp.
std::optional<double> time_of(const Description& description, const char* message);

/// Goes through all messages that are whole; their descriptions grow on the way.
Damage walk(const std::string& path, Descriptions& descriptions, const Progress& progress,
            const std::function<void(std::uint8_t id, const char* message)>& take);

}  // namespace tumble::dataflash
