#pragma once

#include <string>
#include <string_view>

#include "tumble/core/estimate.hpp"
#include "tumble/language/section_words.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/markup.hpp"

namespace tumble::html {

using tumble::escaped;
using tumble::palette;

/// Words of the page in its language: section [report] of text/<language>.toml.
using Words = SectionWords;

/// A number text of rounding.hpp with a true minus sign and its exponent as a power: "(6.66 ± 0.01) × 10⁻⁵".
std::string number(std::string_view text);
/// "deg/h^2" with the exponent raised; "1" is empty.
std::string unit(const Unit& unit);
/// "K_1" with the index below: all behind the first underscore.
std::string symbol(std::string_view text);
/// "angle random walk" and, where it is written differently in files, the name itself: "angle_random_walk".
std::string name_html(std::string_view name, const Words& words, std::string_view method = {});

/// The sections, empty where there is nothing to say.
std::string verdicts(const Estimate& estimate, const Words& words);
std::string parameters(const Estimate& estimate, const Words& words);
std::string with_prior(const Estimate& estimate, const Words& words);
std::string findings(const Estimate& estimate, const Words& words);
std::string budget(const Estimate& estimate, const Words& words);
std::string tables(const Estimate& estimate, const Words& words);
std::string correlation(const Estimate& estimate, const Words& words);
std::string provenance(const Estimate& estimate, const Words& words);
/// The figure that a reader looks for first stands before the numbers, the others behind them.
std::string first_figure(const std::vector<Figure>& figures, const Words& words);
std::string further_figures(const std::vector<Figure>& figures, const Words& words);

/// The style of the page: that of every report, the colours of series, and what paper has above and below the text.
std::string style(const std::string& title, const std::string& serial);

}  // namespace tumble::html
