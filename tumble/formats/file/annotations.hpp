#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/recording.hpp"

namespace tumble::file {

/// Contents of a recording other than channels, as JSON texts by key: instrument, marks, meta; and quantities for
/// channels whose kind does not follow from their unit. Empty contents have no key.
std::map<std::string, std::string> annotations_of(const Recording& recording);

/// Takes one of them back; quantities are returned by channel name in `kinds`. False when the text is not what belongs
/// to the key, and `recording` is as before.
bool annotate(Recording& recording, std::map<std::string, QuantityKind>& kinds, std::string_view key,
              std::string_view json);

/// All annotations as one JSON object, and back. Keys that are not known are kept in meta; false when it is no JSON
/// object.
std::string all_annotations(const Recording& recording);
bool annotate_all(Recording& recording, std::string_view json);

/// The kind of that name; false for an unknown name.
bool kind_named(std::string_view text, QuantityKind& kind);

}  // namespace tumble::file
