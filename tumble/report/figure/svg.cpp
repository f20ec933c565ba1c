#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "tumble/language/section_words.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/figure/colours.hpp"
#include "tumble/report/figure/frame.hpp"
#include "tumble/report/markup.hpp"
#include "tumble/report/utf8.hpp"

namespace tumble {
namespace {

using figure::coloured_points, figure::colours, figure::Frame, figure::ink, figure::linear_ticks,
    figure::logarithmic_ticks, figure::size_of_text, figure::soft, figure::text_at, figure::text_upwards, figure::Ticks,
    figure::title_with, figure::width_of;

constexpr double top = 12, right = 14, line_height = 19;
struct Size {
  double width, plot_height;
  int x_ticks, y_ticks;  ///< at most
};
constexpr Size of_page{760, 330, 9, 7}, of_phone{390, 260, 5, 6};

/// Smallest and largest of what an axis can show.
struct Range {
  bool logarithmic;
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();

  void add(const std::vector<double>& values) {
    constexpr double most = 1e300, least = 1e-300;  // beyond these a difference or a quotient of two has no double
    for (const double value : values)
      if (std::abs(value) < most && (value > least || !logarithmic))
        low = std::min(low, value), high = std::max(high, value);
  }
  bool empty() const { return !(low <= high); }
};

Ticks ticks_of(const Range& range, int most) {
  const double low = range.empty() ? 0.1 : range.low, high = range.empty() ? 1.0 : range.high;
  return range.logarithmic ? logarithmic_ticks(low, high, most) : linear_ticks(low, high, most);
}

/// A lower edge may go on far below the values of a logarithmic axis, where nothing is to be seen: two decades show it.
void add_bands(const Figure& figure, Range& y) {
  const double values = y.low;
  for (const auto& series : figure.series)
    for (const auto* edge : {&series.lower, &series.upper}) y.add(*edge);
  if (figure.y.logarithmic && std::isfinite(values)) y.low = std::max(y.low, 0.01 * values);
}

/// `room` [px] is for what stands to the right of the plot.
Frame frame_of(const Figure& figure, const Size& size, double room) {
  Range x{figure.x.logarithmic}, y{figure.y.logarithmic};
  for (const auto& series : figure.series) x.add(series.x), y.add(series.y);
  if (figure.map) x.add(figure.map->x), y.add(figure.map->y);
  add_bands(figure, y);
  Frame frame{ticks_of(x, size.x_ticks), ticks_of(y, size.y_ticks), 0.0, 0.0, size.plot_height};
  double widest = 0.0;
  for (const auto& text : frame.y.labels) widest = std::max(widest, width_of(text));
  frame.left = 30 + widest;
  frame.plot_width = size.width - frame.left - right - room;
  return frame;
}

/// The names of the axes, which stay within the drawing.
std::string titles(const Figure& figure, const Frame& frame, const Size& size) {
  const double middle = 0.5 * frame.plot_width;
  const double room = 2.0 * std::min(frame.left + middle, size.width - frame.left - middle);
  const auto across = figure::fitted(title_with(figure.x, frame.x.exponent), room);
  return text_at(middle, frame.plot_height + 39, "middle", across.text, across.more.c_str()) +
         text_upwards(14 - frame.left, 0.5 * frame.plot_height, frame.plot_height + 2.0 * top,
                      title_with(figure.y, frame.y.exponent));
}

std::string axes(const Figure& figure, const Frame& frame, const Size& size) {
  std::string lines, minor, labels;
  for (const double at : frame.x.minor) minor += fmt::format("M{:.1f} 0V{}", frame.across(at), frame.plot_height);
  for (const double at : frame.y.minor) minor += fmt::format("M0 {:.1f}H{:.1f}", frame.down(at), frame.plot_width);
  for (std::size_t i = 0; i < frame.x.at.size(); ++i) {
    const double x = frame.across(frame.x.at[i]);
    lines += fmt::format("M{:.1f} 0V{}", x, frame.plot_height);
    const double half = 0.58 * width_of(frame.x.labels[i]), last = size.width - frame.left - half;
    labels += text_at(std::min(x, last), frame.plot_height + 18, "middle", frame.x.labels[i]);
  }
  for (std::size_t i = 0; i < frame.y.at.size(); ++i) {
    const double y = frame.down(frame.y.at[i]);
    lines += fmt::format("M0 {:.1f}H{:.1f}", y, frame.plot_width);
    labels += text_at(-7, y + 4, "end", frame.y.labels[i]);
  }
  labels += titles(figure, frame, size);
  return fmt::format(
      "<path d=\"{}\" stroke=\"{}\" stroke-width=\".5\"/>\n<path d=\"{}\" stroke=\"{}\"/>\n"
      "<path d=\"M0 0H{:.1f}V{}H0Z\" stroke=\"{}\"/>\n<g fill=\"{}\">\n{}</g>\n",
      minor, figure::grid, lines, figure::grid, frame.plot_width, frame.plot_height, soft, ink, labels);
}

bool is_drawn(const Figure::Series& series, std::size_t i) {
  return std::isfinite(series.x[i]) && std::isfinite(series.y[i]);
}

/// One stroke for each part between gaps.
std::string line(const Figure::Series& series, const Frame& frame) {
  std::string path;
  bool drawing = false;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const bool is = is_drawn(series, i);
    if (is)
      path += fmt::format("{}{:.1f} {:.1f}", drawing ? 'L' : 'M', frame.across(series.x[i]), frame.down(series.y[i]));
    drawing = is;
  }
  return path;
}

/// Strokes without length, to which the end of the pen gives its shape.
std::string markers(const Figure::Series& series, const Frame& frame) {
  std::string path;
  for (std::size_t i = 0; i < series.x.size(); ++i)
    if (is_drawn(series, i))
      path += fmt::format("M{:.1f} {:.1f}h0", frame.across(series.x[i]), frame.down(series.y[i]));
  return path;
}

bool has_band(const Figure::Series& series, std::size_t i) {
  return std::isfinite(series.x[i]) && std::isfinite(series.lower[i]) && std::isfinite(series.upper[i]);
}

/// Down to where a logarithmic axis ends.
double edge(const Frame& frame, double value) {
  return frame.down(std::max(value, frame.y.logarithmic ? 0.1 * frame.y.lower : value));
}

std::string bars(const Figure::Series& series, const Frame& frame) {
  std::string path;
  for (std::size_t i = 0; i < series.x.size(); ++i)
    if (has_band(series, i))
      path += fmt::format("M{:.1f} {:.1f}V{:.1f}", frame.across(series.x[i]), edge(frame, series.lower[i]),
                          edge(frame, series.upper[i]));
  return path;
}

/// Along the upper edge and back along the lower, for each part between gaps.
std::string band(const Figure::Series& series, const Frame& frame) {
  std::string path;
  const std::size_t count = series.x.size();
  for (std::size_t begin = 0, end; begin < count; begin = end + 1) {
    for (end = begin; end < count && has_band(series, end);) ++end;
    for (std::size_t i = begin; i < end; ++i)
      path += fmt::format("{}{:.1f} {:.1f}", i == begin ? 'M' : 'L', frame.across(series.x[i]),
                          edge(frame, series.upper[i]));
    for (std::size_t i = end; i > begin; --i)
      path += fmt::format("L{:.1f} {:.1f}", frame.across(series.x[i - 1]), edge(frame, series.lower[i - 1]));
    if (end > begin) path += 'Z';
  }
  return path;
}

/// How a pen marks points: round for every other series, else square.
std::string pen_of_points(std::size_t index) {
  return fmt::format("stroke-width=\"5\" stroke-linecap=\"{}\"", index % 2 == 0 ? "round" : "square");
}

std::string pen_of_line(const SeriesStyle& style) {
  return "stroke-width=\"1.6\" stroke-linejoin=\"round\"" +
         (style.dashes.empty() ? "" : " stroke-dasharray=\"" + style.dashes + "\"");
}

std::string drawn(const Figure::Series& series, std::size_t index, const Frame& frame, const Ticks& scale) {
  const auto style = style_of_series(index);
  std::string text;
  if (!series.z.empty()) return coloured_points(series, frame, scale);
  if (!series.lower.empty() && series.points)
    text += fmt::format("<path d=\"{}\" stroke=\"{}\" stroke-width=\"1.2\"/>\n", bars(series, frame), style.colour);
  if (!series.lower.empty() && !series.points)
    text += fmt::format("<path d=\"{}\" fill=\"{}\" fill-opacity=\".18\"/>\n", band(series, frame), style.colour);
  return text + fmt::format("<path d=\"{}\" stroke=\"{}\" {}/>\n",
                            series.points ? markers(series, frame) : line(series, frame), style.colour,
                            series.points ? pen_of_points(index) : pen_of_line(style));
}

/// The legend under the plot, in as many rows as it needs; `height` is what it takes.
std::string legend(const Figure& figure, const Frame& frame, double& height) {
  constexpr double sample = 26, gap = 18;
  std::string text;
  double x = 0.0, y = frame.plot_height + 63;
  for (std::size_t i = 0; i < figure.series.size(); ++i) {
    const auto& series = figure.series[i];
    const auto name = figure::fitted(series.name, frame.plot_width + right - sample - 6);
    const double needed = sample + 6 + std::min(width_of(name.text), frame.plot_width + right - sample - 6) + gap;
    if (x > 0.0 && x + needed - gap > frame.plot_width) x = 0.0, y += line_height;
    auto style = style_of_series(i);
    if (!series.z.empty()) style.colour = colours()[colours().size() / 2];
    text +=
        fmt::format("<path d=\"M{:.1f} {:.1f}h{}\" stroke=\"{}\" {}/>\n", series.points ? x + 0.5 * sample : x, y - 4,
                    series.points ? 0.0 : sample, style.colour, series.points ? pen_of_points(i) : pen_of_line(style));
    text += text_at(x + sample + 6, y, "start", name.text, fmt::format(" fill=\"{}\"{}", ink, name.more).c_str());
    x += needed;
  }
  height = figure.series.empty() ? frame.plot_height + 49 : y + 10;
  return text;
}

/// The plot in words, for readers who do not see it.
std::string in_words(const Figure& figure) {
  const SectionWords words{figure.language, "report"};
  const auto text = words.with("plot_of", figure.y.name, figure.x.name,
                               figure.y.logarithmic   ? words("plot_logarithmic")
                               : figure.x.logarithmic ? words("plot_logarithmic_x")
                                                      : "");
  std::string names;
  const auto add = [&](const std::string& name) { names += (names.empty() ? "" : words("plot_next")) + name; };
  for (const auto& series : figure.series) add(series.name);
  if (figure.z) add(words.with("plot_colours", figure.z->name));
  return text + names;
}

/// Letters of the page; in Chinese those of mainland China.
std::string letters_of(Language language) {
  constexpr const char* latin = "system-ui, 'Segoe UI', Roboto, 'Noto Sans', 'Liberation Sans', Arial";
  if (language == Language::english) return fmt::format("font-family=\"{}, sans-serif\"", latin);
  return fmt::format(
      "lang=\"zh-CN\" font-family=\"{}, 'PingFang SC', 'Microsoft YaHei', 'Noto Sans CJK SC', 'Source Han Sans SC', "
      "sans-serif\"",
      latin);
}

}  // namespace

namespace figure {

double width_of(std::string_view text) {
  constexpr double width_of_character = 0.56 * size_of_text;
  return width_of_character * static_cast<double>(display_width(text));
}

std::string text_at(double x, double y, const char* anchor, std::string_view text, const char* more) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more,
                     escaped(text));
}

FittedText fitted(std::string_view text, double room) {
  constexpr double smallest = 0.75;
  std::string whole = printable(text);
  const double needed = width_of(whole);
  if (needed <= room) return {std::move(whole), ""};
  const double size = std::max(smallest, room / needed), columns = room / size / width_of("0");
  return {without_middle(whole, static_cast<std::size_t>(std::max(1.0, columns + 1e-6))),
          fmt::format(" font-size=\"{:.1f}\"", std::floor(10.0 * size * size_of_text) / 10.0)};
}

std::string text_upwards(double x, double y, double room, std::string_view text) {
  const auto [shown, more] = fitted(text, room);
  return text_at(x, y, "middle", shown, fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"{}", x, y, more).c_str());
}

std::string title_with(const Figure::Axis& axis, int exponent) {
  return exponent == 0 ? title_of(axis) : title_of(axis) + " × " + power_of_ten(exponent);
}

}  // namespace figure

std::string to_svg(const Figure& figure, Drawing drawing) {
  const Size& size = drawing == Drawing::page ? of_page : of_phone;
  const Ticks scale = figure::scale_of(figure, size.y_ticks);
  const Frame frame = frame_of(figure, size, figure.z ? figure::room_of_scale(scale) - right : 0.0);
  double height = 0.0;
  std::string below = legend(figure, frame, height), lines;
  if (figure.z) below += figure::drawn_scale(*figure.z, frame, scale);
  if (figure.map) lines += figure::cells(*figure.map, frame, scale);
  for (std::size_t i = 0; i < figure.series.size(); ++i) lines += drawn(figure.series[i], i, frame, scale);
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {:.0f}\" role=\"img\" aria-label=\"{}\" {} "
      "font-size=\"{}\" fill=\"none\">\n<title>{}</title>\n<g transform=\"translate({:.1f} {})\">\n{}"
      "<svg width=\"{:.1f}\" height=\"{}\">\n{}</svg>\n{}</g>\n</svg>\n",
      size.width, height + top, escaped(in_words(figure)), letters_of(figure.language), size_of_text,
      escaped(figure.name), frame.left, top, axes(figure, frame, size), frame.plot_width, frame.plot_height, lines,
      below);
}

}  // namespace tumble
