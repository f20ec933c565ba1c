#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/language/text.hpp"

namespace tumble {

/// One plot as every renderer draws it: report, certificate, Python and browser say the same with the same points.
struct Figure {
  struct Axis {
    std::string name;
    Unit unit;
    bool logarithmic = false;
  };
  /// Numbers in the units of the axes. NaN is a gap; on a logarithmic axis no number is zero or negative.
  struct Series {
    std::string name;
    bool points = false;  ///< markers instead of a line
    std::vector<double> x, y;
    std::vector<double> lower, upper;  ///< band, or bars where the series is points; empty: none
    std::string band;                  ///< what the band is, for example "95 % confidence"
    std::vector<double> z = {};        ///< of the axis z, shown by the colour of each point; empty: one colour
  };
  /// Cells behind the series, each with the colour of its number on the axis z.
  struct Map {
    std::vector<double> x, y;    ///< edges of columns and rows, rising, in the units of the axes
    std::vector<double> values;  ///< row after row, that of the smallest y first, in the unit of z; NaN: no cell
  };
  std::string name;  ///< never empty
  Axis x, y;
  std::vector<Series> series;
  std::vector<std::string> notes;         ///< sentences on what the plot does not show
  std::optional<Axis> z = {};             ///< what colours show; linear; absent: nothing
  std::optional<Map> map = {};            ///< only with z
  Language language = Language::english;  ///< of its words: see in_language.hpp
};

/// The plots of a result: the curves of one figure and of the same dimensions in one plot, in the units of the first.
/// Where several plots show one quantity of several outputs, a plot of all of them comes first. A result whose curves
/// show no residuals has plots of those of its tables. A curve of more than 5000 points is drawn with fewer: the
/// smallest and the largest of each interval remain. Maps are drawn last, as
/// figure/maps.hpp says.
std::vector<Figure> figures_of(const Estimate& estimate);

/// "name [unit]" of an axis, plain text; the unit 1 is not written.
std::string title_of(const Figure::Axis& axis);

/// The description for programs: an array of figures with name, x, y (name, unit, logarithmic), series and notes.
/// Numbers have nine significant digits; null is a gap. Each series has its colour and the dashes of its line. A figure
/// with an axis z has the colours of its scale from `low` to `high`, and its ticks.
std::string to_json(const std::vector<Figure>& figures);

/// A drawing of its own: axes with ticks, bands or bars, lines with colour and dashes, markers, a legend. It needs no
/// style sheet, no script and no network, and has the plot in words for readers who do not see it.
enum class Drawing { page, phone };  ///< phone: narrow, with letters that are readable at 360 px
std::string to_svg(const Figure& figure, Drawing drawing = Drawing::page);

/// The numbers of a figure for a spreadsheet: a column for x and one for each y and each edge of a band, in the units
/// of the axes. Series of the same x share the columns of x. A map comes first, a row for each cell.
std::string to_csv(const Figure& figure);

/// With at most `most` points in each series: the smallest and the largest of each interval remain.
Figure with_fewer_points(const Figure& figure, std::size_t most);

/// How series number `index` is drawn. Colours are distinguished also by people who see no red or green; the dashes are
/// a second sign.
struct SeriesStyle {
  std::string colour, dark, dashes;  ///< of CSS: "#0072b2", its colour on a dark page, "7 3"; no dashes: a whole line
};
SeriesStyle style_of_series(std::size_t index);

}  // namespace tumble
