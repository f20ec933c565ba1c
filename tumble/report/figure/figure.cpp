#include "tumble/report/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/report/decimate.hpp"
#include "tumble/report/figure/colours.hpp"
#include "tumble/report/figure/derived.hpp"
#include "tumble/report/figure/maps.hpp"
#include "tumble/report/markup.hpp"
#include "tumble/report/names.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

/// Curves drawn in one coordinate system: the same figure and the same dimensions.
struct Group {
  std::string name;
  std::vector<const Curve*> curves;
  bool logarithmic = false, logarithmic_x = false;

  const Curve::Axis& x() const { return curves.front()->x; }
  const Curve::Axis& y() const { return curves.front()->y; }
};

std::vector<Group> groups_of(const std::vector<Curve>& curves) {
  std::vector<Group> groups;
  for (const auto& curve : curves) {
    const auto fits = [&](const Group& group) {
      return group.name == curve.figure && group.x().unit.dimension() == curve.x.unit.dimension() &&
             group.y().unit.dimension() == curve.y.unit.dimension();
    };
    auto group = std::ranges::find_if(groups, fits);
    if (group == groups.end()) group = groups.insert(groups.end(), Group{curve.figure, {}});
    group->curves.push_back(&curve);
    group->logarithmic = group->logarithmic || curve.logarithmic;
    group->logarithmic_x = group->logarithmic_x || curve.logarithmic || curve.logarithmic_x;
  }
  return groups;
}

/// A logarithmic axis has no place for zero and less: such points become gaps, and the lower edge of a band ends at the
/// smallest positive value of the curve. Returns how many points became gaps.
std::size_t keep_positive(const Group& group, Curve& curve) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto* values : {&curve.y.values, &curve.lower, &curve.upper})
    for (const double value : *values)
      if (value > 0.0) smallest = std::min(smallest, value);
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < curve.y.values.size(); ++i) {
    double &x = curve.x.values[i], &y = curve.y.values[i];
    const bool beside = group.logarithmic_x && !(x > 0.0), below = group.logarithmic && !(y > 0.0);
    if ((beside || below) && std::isfinite(x) && std::isfinite(y)) ++dropped;
    if (beside) x = NAN;
    if (beside || below) y = NAN;
  }
  if (!group.logarithmic) return dropped;
  for (double& value : curve.lower) value = value <= 0.0 ? smallest : value;
  for (double& value : curve.upper) value = value <= 0.0 ? NAN : value;
  return dropped;
}

std::vector<double> chosen(const std::vector<double>& values, const std::vector<std::size_t>& indices,
                           const Unit& unit) {
  std::vector<double> result;
  if (values.empty()) return result;
  result.reserve(indices.size());
  for (const auto i : indices) result.push_back(unit.from_si(values[i]));
  return result;
}

/// Which curves do not show every value, and how many.
struct Missing {
  std::string not_positive, shortened;

  static void add(std::string& list, const Curve& curve, const std::string& what) {
    list += (list.empty() ? "" : ", ") + fmt::format("“{}” {}", curve.name, what);
  }
};

Figure::Series series_of(const Curve& original, const Group& group, Missing& missing) {
  Curve curve = original;
  const auto dropped = keep_positive(group, curve);
  if (dropped > 0) Missing::add(missing.not_positive, curve, fmt::format("{} values", dropped));
  const auto indices = points_to_draw(curve.x.values, curve.y.values, curve.lower, curve.upper, group.logarithmic_x);
  const auto count = curve.x.values.size();
  if (indices.size() < count)
    Missing::add(missing.shortened, curve, fmt::format("{} of {} points", indices.size(), count));
  const Unit &x = group.x().unit, &y = group.y().unit;
  return {readable_name(curve.name),
          curve.points,
          chosen(curve.x.values, indices, x),
          chosen(curve.y.values, indices, y),
          chosen(curve.lower, indices, y),
          chosen(curve.upper, indices, y),
          curve.band};
}

Figure figure_of(const Group& group) {
  Figure figure{readable_name(group.name.empty() ? group.y().name + " over " + group.x().name : group.name),
                {readable_name(group.x().name), group.x().unit, group.logarithmic_x},
                {readable_name(group.y().name), group.y().unit, group.logarithmic},
                {},
                {}};
  Missing missing;
  for (const auto* curve : group.curves) figure.series.push_back(series_of(*curve, group, missing));
  if (!missing.not_positive.empty())
    figure.notes.push_back("Zero or negative, and therefore not drawn on logarithmic axes: " + missing.not_positive);
  if (!missing.shortened.empty())
    figure.notes.push_back("Drawn with fewer points; the smallest and the largest of each interval remain: " +
                           missing.shortened + "; the result file has all points");
  return figure;
}

using Json = nlohmann::ordered_json;

/// Nine significant digits: far below what a screen can show, and half the size of the page.
Json short_number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return rounded_to_digits(value, 9);
}

Json numbers(const std::vector<double>& values) {
  auto array = Json::array();
  for (const double value : values) array.push_back(short_number(value));
  return array;
}

Json described(const Figure::Axis& axis) {
  return {{"name", axis.name}, {"unit", axis.unit.text()}, {"logarithmic", axis.logarithmic}};
}

Json described(const Figure::Series& series, std::size_t index) {
  const auto style = style_of_series(index);
  Json result{{"name", series.name},    {"points", series.points}, {"colour", style.colour}, {"dark", style.dark},
              {"dashes", style.dashes}, {"x", numbers(series.x)},  {"y", numbers(series.y)}};
  if (!series.lower.empty()) {
    result["band"] = series.band;
    result["lower"] = numbers(series.lower);
    result["upper"] = numbers(series.upper);
  }
  if (!series.z.empty()) result["z"] = numbers(series.z);
  return result;
}

/// The axis z: its colours from low to high, and where its ticks are between them, 0 to 1.
Json described(const Figure::Axis& axis, const figure::Ticks& scale) {
  auto ticks = Json::array();
  for (std::size_t i = 0; i < scale.at.size(); ++i)
    ticks.push_back({{"at", short_number(scale.place(scale.at[i]))}, {"label", scale.labels[i]}});
  Json result = described(axis);
  result["title"] = figure::title_with(axis, scale.exponent);
  result["low"] = short_number(scale.lower);
  result["high"] = short_number(scale.upper);
  result["colours"] = figure::colours();
  result["ticks"] = std::move(ticks);
  return result;
}

}  // namespace

std::vector<Figure> figures_of(const Estimate& estimate) {
  std::vector<Figure> figures;
  const auto curves = figure::curves_to_draw(estimate);
  for (const Group& group : groups_of(curves)) figures.push_back(figure_of(group));
  figure::add_overviews(figures);
  for (auto& map : figure::maps_of(estimate)) figures.push_back(std::move(map));
  return figures;
}

std::string title_of(const Figure::Axis& axis) {
  const std::string unit(axis.unit.text());
  return axis.name + (unit == "1" ? "" : " [" + unit + "]");
}

std::string to_json(const std::vector<Figure>& figures) {
  auto all = Json::array();
  for (const Figure& figure : figures) {
    auto series = Json::array();
    for (std::size_t i = 0; i < figure.series.size(); ++i) series.push_back(described(figure.series[i], i));
    all.push_back({{"name", figure.name},
                   {"x", described(figure.x)},
                   {"y", described(figure.y)},
                   {"series", std::move(series)},
                   {"notes", figure.notes}});
    if (!figure.z) continue;
    all.back()["z"] = described(*figure.z, figure::scale_of(figure, 6));
    if (figure.map)
      all.back()["map"] = {
          {"x", numbers(figure.map->x)}, {"y", numbers(figure.map->y)}, {"values", numbers(figure.map->values)}};
  }
  return json_text(all, 1);
}

SeriesStyle style_of_series(std::size_t index) {
  static const char* const dashes[] = {"", "7 3", "2 2.5", "9 3 2 3", "12 4", "5 2 1.5 2 1.5 2"};
  const auto colour = index % palette().size();
  return {palette()[colour], palette_on_dark()[colour], dashes[index % std::size(dashes)]};
}

}  // namespace tumble
