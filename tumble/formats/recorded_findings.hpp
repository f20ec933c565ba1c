#pragma once

#include <map>
#include <string>
#include <string_view>

#include "tumble/core/finding.hpp"

namespace tumble {

/// Key of Recording::meta: the findings of the program that recorded, as JSON. Every reader hands them out again, so
/// that a result says what happened while its data were recorded.
inline constexpr std::string_view recorded_findings_key = "recorded_findings";

std::string text_of_findings(const Findings& findings);

/// Findings that a file has in its meta; none where it has none, or where the text is damaged.
Findings recorded_findings(const std::map<std::string, std::string>& meta);

}  // namespace tumble
