#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/rounding.hpp"

namespace tumble::python {
namespace {

using Numbers = nb::ndarray<nb::numpy, const double, nb::ndim<1>>;

Numbers view(const std::vector<double>& values) { return {values.data(), {values.size()}, nb::handle()}; }

template <std::vector<double> Figure::Series::*member>
Numbers numbers(const Figure::Series& series) {
  return view(series.*member);
}

template <std::vector<double> Figure::Map::*member>
Numbers cells(const Figure::Map& map) {
  return view(map.*member);
}

/// Each line of the budget as the report shows it: source, and its share [1] of the variance of each parameter.
std::vector<std::pair<std::string, std::vector<double>>> budget_shares(const Estimate& estimate) {
  std::vector<std::pair<std::string, std::vector<double>>> lines;
  for (const auto& part : budget_to_show(estimate)) {
    std::vector<double> shares;
    for (std::size_t i = 0; i < estimate.parameters.size(); ++i)
      shares.push_back(part.variance(i) / estimate.covariance(i, i));
    lines.emplace_back(part.source, std::move(shares));
  }
  return lines;
}

}  // namespace

void bind_figures(nb::module_& module) {
  using namespace nb::literals;
  using Series = Figure::Series;
  constexpr auto inside = nb::rv_policy::reference_internal;
  nb::class_<Figure> figure(module, "Figure");
  nb::class_<Figure::Axis>(figure, "Axis")
      .def_ro("name", &Figure::Axis::name)
      .def_prop_ro("unit", [](const Figure::Axis& axis) { return axis.unit.text(); })
      .def_prop_ro("title", &title_of)
      .def_ro("logarithmic", &Figure::Axis::logarithmic);
  nb::class_<Series>(figure, "Series")
      .def_ro("name", &Series::name)
      .def_ro("points", &Series::points)
      .def_prop_ro("x", &numbers<&Series::x>, inside)
      .def_prop_ro("y", &numbers<&Series::y>, inside)
      .def_prop_ro("lower", &numbers<&Series::lower>, inside)
      .def_prop_ro("upper", &numbers<&Series::upper>, inside)
      .def_ro("band", &Series::band)
      .def_prop_ro("z", &numbers<&Series::z>, inside);
  nb::class_<Figure::Map>(figure, "Map")
      .def_prop_ro("x", &cells<&Figure::Map::x>, inside)
      .def_prop_ro("y", &cells<&Figure::Map::y>, inside)
      .def_prop_ro("values", &cells<&Figure::Map::values>, inside);
  figure.def_ro("name", &Figure::name)
      .def_ro("x", &Figure::x)
      .def_ro("y", &Figure::y)
      .def_ro("series", &Figure::series)
      .def_ro("notes", &Figure::notes)
      .def_ro("z", &Figure::z)
      .def_ro("map", &Figure::map)
      .def("to_svg", [](const Figure& one) { return to_svg(one); })
      .def("to_json", [](const Figure& one) { return to_json({one}); });
  nb::class_<SeriesStyle>(module, "SeriesStyle")
      .def_ro("colour", &SeriesStyle::colour)
      .def_ro("dashes", &SeriesStyle::dashes);
  module.def("figures_of", &figures_of, "estimate"_a, nb::call_guard<Unlocked>());
  module.def("budget_shares", &budget_shares, "estimate"_a);
  module.def("style_of_series", &style_of_series, "index"_a);
}

}  // namespace tumble::python
