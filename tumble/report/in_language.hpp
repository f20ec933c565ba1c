#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/language/text.hpp"
#include "tumble/report/figure.hpp"

namespace tumble {

/// The result as people who read this language see it: title, descriptions, sources of the budget, captions, columns
/// and sentences in the cells of tables. Names of parameters stay, because limits and settings have them, and so do
/// names of tables; pages show them by readable_name(language, name). It is made for showing: what reads the result by
/// the names of its columns, figures_of() and compensate(), needs the original.
Estimate in_language(Language language, Estimate estimate);

/// Whether the cells of a column are names of segments, channels, parameters and files, which stay as plans and
/// recordings have them.
bool has_names(const std::string& column);

/// Name, axes, series, bands and notes of a figure for people who read this language.
Figure in_language(Language language, Figure figure);
std::vector<Figure> in_language(Language language, std::vector<Figure> figures);

}  // namespace tumble
