#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/formats/topics/topic.hpp"

namespace tumble::ulog {

/// A field of a message: "float[3] gyro_rad".
struct Field {
  std::string type;
  std::size_t length = 1;  ///< of the array
  std::string name;

  bool operator==(const Field&) const = default;
};

/// Fields of the messages of a log, by the name of the format.
using Definitions = std::map<std::string, std::vector<Field>, std::less<>>;

/// Takes "name:type field;type[n] field;". False where it is not of that form.
bool define(std::string_view text, Definitions& definitions);

/// Whether a message of this format holds one of the named formats, itself or in a format within it.
bool holds(const Definitions& definitions, const std::string& format, const std::set<std::string>& names);

/// The number of this type; nothing for text and for a format.
std::optional<topics::Number> number_of(std::string_view type);

/// Sizes of messages [bytes].
struct Size {
  std::size_t least = 0;  ///< without the padding at the end, which may be absent
  std::size_t most = 0;
};

/// Nothing where a format is missing, contains itself, or is larger than a message can be.
std::optional<Size> size_of(const Definitions& definitions, const std::string& format);

/// A number in a message: "gyro_rad.0", or "parent.child" of a nested format.
struct Place {
  std::string field;
  std::size_t offset;  ///< [bytes] from the beginning of the message
  topics::Number number;
  std::size_t length;  ///< of the array
};

/// All numbers of a format whose size is known: no padding, no text. An array of up to eight has a place for each
/// number, a longer one has a single place.
std::vector<Place> places_in(const Definitions& definitions, const std::string& format);

}  // namespace tumble::ulog
