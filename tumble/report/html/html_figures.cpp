#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tumble/report/decimate.hpp"
#include "tumble/report/html/html.hpp"

namespace tumble::html {
namespace {

using Json = nlohmann::ordered_json;

/// Curves drawn in one coordinate system: the same figure and the same dimensions.
struct Plot {
  std::string figure;
  std::vector<const Curve*> curves;
  bool logarithmic = false, logarithmic_x = false;
  std::string not_positive, shortened;  ///< which curves do not show every value, and how many

  const Curve::Axis& x() const { return curves.front()->x; }
  const Curve::Axis& y() const { return curves.front()->y; }
};

std::vector<Plot> plots_of(const Estimate& estimate) {
  std::vector<Plot> plots;
  for (const auto& curve : estimate.curves) {
    const auto fits = [&](const Plot& plot) {
      return plot.figure == curve.figure && plot.x().unit.dimension() == curve.x.unit.dimension() &&
             plot.y().unit.dimension() == curve.y.unit.dimension();
    };
    auto plot = std::find_if(plots.begin(), plots.end(), fits);
    if (plot == plots.end()) plot = plots.insert(plots.end(), Plot{curve.figure, {}, false, false, {}, {}});
    plot->curves.push_back(&curve);
    plot->logarithmic = plot->logarithmic || curve.logarithmic;
    plot->logarithmic_x = plot->logarithmic_x || curve.logarithmic || curve.logarithmic_x;
  }
  return plots;
}

/// Nine significant digits: far below what a screen can show, and half the size of the page.
Json short_number(double value) {
  if (!std::isfinite(value)) return nullptr;
  const auto text = fmt::format("{:.9g}", value);
  double result = value;
  std::from_chars(text.data(), text.data() + text.size(), result);
  return result;
}

Json numbers(const std::vector<double>& values, const std::vector<std::size_t>& indices, const Unit& unit) {
  auto array = Json::array();
  for (const auto i : indices) array.push_back(short_number(unit.from_si(values[i])));
  return array;
}

/// Logarithmic axes have no place for zero and less: values become gaps, the lower edge of a band ends at the smallest
/// positive value of the curve. Returns how many values became gaps.
std::size_t keep_positive(Curve& curve) {
  double smallest = std::numeric_limits<double>::infinity();
  std::size_t dropped = 0;
  for (const auto* values : {&curve.y.values, &curve.lower, &curve.upper}) {
    for (const double value : *values) {
      if (value > 0.0) smallest = std::min(smallest, value);
    }
  }
  for (std::size_t i = 0; i < curve.y.values.size(); ++i) {
    if (curve.y.values[i] > 0.0 && curve.x.values[i] > 0.0) continue;
    if (std::isfinite(curve.y.values[i])) ++dropped;
    curve.y.values[i] = NAN;
  }
  for (double& value : curve.lower) value = value <= 0.0 ? smallest : value;
  for (double& value : curve.upper) value = value <= 0.0 ? NAN : value;
  return dropped;
}

void add(std::string& list, const Curve& curve, const std::string& what) {
  list += (list.empty() ? "" : ", ") + fmt::format("“{}” {}", escaped(curve.name), what);
}

Json trace(const Curve& original, Plot& plot) {
  Curve curve = original;
  const auto dropped = plot.logarithmic ? keep_positive(curve) : 0;
  if (dropped > 0) add(plot.not_positive, curve, fmt::format("{} values", dropped));
  const auto indices = points_to_draw(curve.x.values, curve.y.values, curve.lower, curve.upper, plot.logarithmic_x);
  const auto count = curve.x.values.size();
  if (indices.size() < count) add(plot.shortened, curve, fmt::format("{} of {} points", indices.size(), count));
  Json result{{"name", escaped(curve.name)},
              {"points", curve.points},
              {"x", numbers(curve.x.values, indices, plot.x().unit)},
              {"y", numbers(curve.y.values, indices, plot.y().unit)}};
  if (!curve.lower.empty()) {
    result["band"] = escaped(curve.band);
    result["lower"] = numbers(curve.lower, indices, plot.y().unit);
    result["upper"] = numbers(curve.upper, indices, plot.y().unit);
  }
  return result;
}

Json drawing(Plot& plot, std::size_t number) {
  auto traces = Json::array();
  for (const auto* curve : plot.curves) traces.push_back(trace(*curve, plot));
  return {{"place", fmt::format("plot-{}", number)},
          {"x", name_and_unit(plot.x().name, plot.x().unit)},
          {"y", name_and_unit(plot.y().name, plot.y().unit)},
          {"logarithmic", plot.logarithmic},
          {"logarithmic_x", plot.logarithmic_x},
          {"colours", palette()},
          {"traces", std::move(traces)}};
}

/// The figure in words, for readers who do not see it.
std::string description(const Plot& plot) {
  std::string text =
      fmt::format("Plot of {} over {}{}:", name_and_unit(plot.y().name, Unit{}), name_and_unit(plot.x().name, Unit{}),
                  plot.logarithmic     ? ", logarithmic axes"
                  : plot.logarithmic_x ? ", logarithmic x axis"
                                       : "");
  for (const auto* curve : plot.curves) text += (curve == plot.curves.front() ? " " : ", ") + escaped(curve->name);
  return text;
}

std::string caption(const Plot& plot, std::size_t number) {
  const auto name = plot.figure.empty() ? plot.y().name + " over " + plot.x().name : plot.figure;
  std::string text = fmt::format("<b>Figure {}.</b> {}.", number, escaped(name));
  for (const auto* curve : plot.curves) {
    if (curve->lower.empty() || curve->band.empty()) continue;
    text +=
        fmt::format(" {} of “{}”: {}.", curve->points ? "Bars" : "Band", escaped(curve->name), escaped(curve->band));
  }
  if (!plot.not_positive.empty()) {
    text += " Zero or negative, and therefore not drawn on logarithmic axes: " + plot.not_positive + ".";
  }
  if (!plot.shortened.empty()) {
    text += " Drawn with fewer points; the smallest and the largest of each interval remain: " + plot.shortened +
            "; the result file has all points.";
  }
  return text;
}

/// JSON that may stand in a script element: nothing in it can end the element or open a comment.
std::string in_script(const Json& json) {
  std::string result;
  for (const char c : json.dump(-1, ' ', true, Json::error_handler_t::replace)) {
    if (c == '<' || c == '>' || c == '&') {
      result += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  return result;
}

}  // namespace

Figures figures(const Estimate& estimate) {
  if (estimate.curves.empty()) return {};
  auto plots = plots_of(estimate);
  auto drawings = Json::array();
  std::string section = "<section id=\"figures\">\n<h2>Figures</h2>\n";
  for (std::size_t i = 0; i < plots.size(); ++i) {
    const auto number = i + 1;
    drawings.push_back(drawing(plots[i], number));
    section += fmt::format(
        "<figure id=\"figure-{0}\">\n<div class=\"plot\" id=\"plot-{0}\" role=\"img\" aria-label=\"{1}\"></div>\n"
        "<figcaption>{2}</figcaption>\n</figure>\n",
        number, description(plots[i]), caption(plots[i], number));
  }
  section +=
      "<noscript><p class=\"note\">The figures are drawn by a script inside this page, which is switched off."
      "</p></noscript>\n</section>\n";
  return {section, in_script(drawings)};
}

}  // namespace tumble::html
