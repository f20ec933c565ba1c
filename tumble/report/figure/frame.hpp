#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "tumble/report/figure.hpp"
#include "tumble/report/figure/ticks.hpp"

/// Sizes and texts that all parts of a drawing share. Lengths are pixels where the drawing is shown at its own size.
namespace tumble::figure {

// 13.5 of 760 are 9 pt on the text width of A4.
constexpr double size_of_text = 13.5;
constexpr const char* ink = "#1b2733";
constexpr const char* soft = "#51606e";
constexpr const char* grid = "#e1e6eb";

/// The plot's place in the drawing, and where a number of an axis lies in the plot.
struct Frame {
  Ticks x, y;
  double left, plot_width, plot_height;

  /// [px] from the left edge of the plot. Given: a number [u] of the axis; far outside of it the place is limited.
  double across(double value) const { return plot_width * std::clamp(x.place(value), -1.0, 2.0); }
  /// [px] from its upper edge. Given: as across().
  double down(double value) const { return plot_height * (1.0 - std::clamp(y.place(value), -1.0, 2.0)); }
};

/// [px] About what a text takes.
double width_of(std::string_view text);
/// A text and attributes of its element.
struct FittedText {
  std::string text, more;
};
/// A text that takes at most `room` [px]: its letters are as small as that needs; where letters of three quarters of
/// the usual size need more, it is without its middle.
FittedText fitted(std::string_view text, double room);
/// Given: place [px] of its anchor (start, middle, end) on its base line, more attributes.
std::string text_at(double x, double y, const char* anchor, std::string_view text, const char* more = "");
/// Upwards, its middle at this place [px], of at most this length [px].
std::string text_upwards(double x, double y, double room, std::string_view text);
/// "time [s] × 10⁻⁵": what the labels of the ticks lack stands with the name.
std::string title_with(const Figure::Axis& axis, int exponent);

}  // namespace tumble::figure
