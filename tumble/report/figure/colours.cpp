#include "tumble/report/figure/colours.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tumble::figure {
namespace {

constexpr double scale_width = 14.0, gap_before = 16.0, gap_of_labels = 5.0, room_of_title = 22.0;

std::size_t number_of_colour(const Ticks& scale, double value) {
  const double last = static_cast<double>(colours().size() - 1);
  return static_cast<std::size_t>(std::lround(last * std::clamp(scale.place(value), 0.0, 1.0)));
}

double widest_label(const Ticks& scale) {
  double widest = 0.0;
  for (const auto& label : scale.labels) widest = std::max(widest, width_of(label));
  return widest;
}

bool has_colour(const Figure::Series& series, std::size_t i) {
  return std::isfinite(series.x[i]) && std::isfinite(series.y[i]) && std::isfinite(series.z[i]);
}

}  // namespace

const std::vector<std::string>& colours() {
  static const std::vector<std::string> all{"#00224e", "#00285b", "#002e6a", "#053371", "#1c396f", "#293f6e", "#33446d",
                                            "#3c4a6c", "#45506c", "#4d556c", "#555b6d", "#5c616e", "#646770", "#6b6d72",
                                            "#727274", "#787877", "#807f78", "#888578", "#908b78", "#979177", "#a09875",
                                            "#a89e73", "#b0a571", "#b9ab6d", "#c2b369", "#cbb965", "#d3c05f", "#dcc859",
                                            "#e6d051", "#efd748", "#f8df3c", "#fee838"};
  return all;
}

Ticks scale_of(const Figure& figure, int most) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const auto add = [&](const std::vector<double>& values) {
    for (const double value : values)
      if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  };
  if (figure.map) add(figure.map->values);
  for (const auto& series : figure.series) add(series.z);
  return low <= high ? linear_ticks(low, high, most) : linear_ticks(0.0, 1.0, most);
}

const std::string& colour_of(const Ticks& scale, double value) { return colours()[number_of_colour(scale, value)]; }

std::string cells(const Figure::Map& map, const Frame& frame, const Ticks& scale) {
  std::vector<std::string> paths(colours().size());
  for (std::size_t row = 0, at = 0; row + 1 < map.y.size(); ++row)
    for (std::size_t column = 0; column + 1 < map.x.size(); ++column, ++at) {
      if (!std::isfinite(map.values[at])) continue;
      const double left = frame.across(map.x[column]), right = frame.across(map.x[column + 1]);
      const double bottom = frame.down(map.y[row]), top = frame.down(map.y[row + 1]);
      paths[number_of_colour(scale, map.values[at])] +=
          fmt::format("M{:.1f} {:.1f}H{:.1f}V{:.1f}H{:.1f}Z", left, top, right, bottom, left);
    }
  std::string text = "<g shape-rendering=\"crispEdges\">\n";
  for (std::size_t i = 0; i < paths.size(); ++i)
    if (!paths[i].empty()) text += fmt::format("<path d=\"{}\" fill=\"{}\"/>\n", paths[i], colours()[i]);
  return text + "</g>\n";
}

std::string coloured_points(const Figure::Series& series, const Frame& frame, const Ticks& scale) {
  std::vector<std::string> paths(colours().size());
  std::string all;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!has_colour(series, i)) continue;
    const auto point = fmt::format("M{:.1f} {:.1f}h0", frame.across(series.x[i]), frame.down(series.y[i]));
    all += point;
    paths[number_of_colour(scale, series.z[i])] += point;
  }
  std::string text =
      fmt::format("<g stroke-linecap=\"round\">\n<path d=\"{}\" stroke=\"#fff\" stroke-width=\"8\"/>\n", all);
  for (std::size_t i = 0; i < paths.size(); ++i)
    if (!paths[i].empty())
      text += fmt::format("<path d=\"{}\" stroke=\"{}\" stroke-width=\"6\"/>\n", paths[i], colours()[i]);
  return text + "</g>\n";
}

double room_of_scale(const Ticks& scale) {
  return gap_before + scale_width + gap_of_labels + widest_label(scale) + room_of_title;
}

std::string drawn_scale(const Figure::Axis& axis, const Frame& frame, const Ticks& scale) {
  const double left = frame.plot_width + gap_before, height = frame.plot_height;
  const double each = height / static_cast<double>(colours().size());
  std::string text = "<g shape-rendering=\"crispEdges\">\n", labels;
  for (std::size_t i = 0; i < colours().size(); ++i)  // each down to the end, below those that follow: no gaps
    text += fmt::format("<path d=\"M{:.1f} 0h{}V{:.2f}h-{}Z\" fill=\"{}\"/>\n", left, scale_width,
                        height - each * static_cast<double>(i), scale_width, colours()[i]);
  for (std::size_t i = 0; i < scale.at.size(); ++i)
    labels += text_at(left + scale_width + gap_of_labels, height * (1.0 - scale.place(scale.at[i])) + 4, "start",
                      scale.labels[i]);
  labels += text_upwards(left + scale_width + gap_of_labels + widest_label(scale) + room_of_title - 4, 0.5 * height,
                         height, title_with(axis, scale.exponent));
  return text + fmt::format("</g>\n<g fill=\"{}\">\n{}</g>\n", ink, labels);
}

}  // namespace tumble::figure
