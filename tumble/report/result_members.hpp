#pragma once

#include <cmath>
#include <utility>

#include "tumble/core/estimate.hpp"
#include "tumble/report/members.hpp"

/// Members of the parts of a result, as its JSON has them; see members.hpp. Numbers of error models are in SI.
namespace tumble {

template <class Visitor, PossiblyConst<Fit> X>
void members(Visitor& visit, X& x) {
  visit("observations", x.observations)("degrees_of_freedom", x.degrees_of_freedom)("chi_square", x.chi_square);
  visit("condition", x.condition, INFINITY);
}

template <class Visitor, PossiblyConst<PopulationFacts> X>
void members(Visitor& visit, X& x) {
  visit("method", x.method)("sha256", x.sha256)("units", x.units);
  visit("shrinkage", x.shrinkage, INFINITY)("inflation", x.inflation, 1.0);
}

template <class Visitor, PossiblyConst<Curve::Axis> X>
void members(Visitor& visit, X& x) {
  visit("name", x.name)("unit", x.unit)("values", x.values, x.unit);
}

/// Where a curve has as many numbers as it has points.
template <class Visitor>
void expect_as_many_as_points(Visitor& visit, const char* key, std::size_t numbers, const Curve& x) {
  if (numbers != x.x.values.size())
    visit.complain(key, say("{} values are expected ({}), not {}", x.x.values.size(), "one for each x", numbers));
}

template <class Visitor, PossiblyConst<Curve> X>
void members(Visitor& visit, X& x) {
  visit("name", x.name).optional("figure", x.figure, true);
  visit("x", x.x)("y", x.y);
  expect_as_many_as_points(visit, "y", x.y.values.size(), x);
  visit.object("band", !x.lower.empty() || !x.band.empty(), [&x](auto& band) {
    band("name", x.band)("lower", x.lower, x.y.unit)("upper", x.upper, x.y.unit);
    if (x.lower.empty() && x.upper.empty()) return;
    expect_as_many_as_points(band, "lower", x.lower.size(), x);
    expect_as_many_as_points(band, "upper", x.upper.size(), x);
  });
  visit.optional("logarithmic", x.logarithmic, true).optional("points", x.points, true);
  visit.optional("logarithmic_x", x.logarithmic_x, x.logarithmic_x);
}

/// A number [SI] that must not be below zero.
template <class Visitor>
void expect_not_negative(Visitor& visit, const char* key, double value) {
  if (!(value >= 0.0)) visit.complain(key, say("a number from {} is expected", 0));
}

/// The words of the inputs, in their order.
const EnumerationWords& input_words();
/// The words of the forms of a factor, in their order.
const EnumerationWords& form_words();

template <class Visitor, PossiblyConst<TermFactor> X>
void members(Visitor& visit, X& x) {
  using Form = TermFactor::Form;
  constexpr int most_order = 99;
  visit("input", x.input, input_words());
  if (x.input == Input::channel) visit("role", x.role);
  visit.optional("form", x.form, x.form != Form::power, form_words());
  visit.optional("order", x.order, x.order != 1);
  if (x.order > most_order) visit.complain("order", say("must lie between 0 and {}", most_order));
  visit.optional("origin", x.origin, x.origin != 0.0).optional("from_start", x.from_start, x.from_start);
  visit.optional("size", x.size, x.form == Form::decay || x.form == Form::play);
  if (!(x.size > 0.0)) visit.complain("size", say("a number above {} is expected", 0));
  visit.index("lag", x.lag);
}

template <class Visitor, PossiblyConst<Product> X>
void members(Visitor& visit, X& x) {
  visit("weight", x.weight)("factors", x.factors);
}

template <class Visitor, PossiblyConst<ModelTerm> X>
void members(Visitor& visit, X& x) {
  visit("term", x.term).index("parameter", x.parameter);
  visit("least", x.least, -INFINITY)("greatest", x.greatest, INFINITY);
  if (!(x.least <= x.greatest)) visit.complain("least", "must not be above greatest");
  visit.optional("per_output", x.per_output, x.per_output).optional("remains", x.remains, x.remains);
  visit("regressor", x.regressor);
}

/// An input and its weight [SI].
template <class Visitor, PossiblyConst<std::pair<Input, double>> X>
void members(Visitor& visit, X& x) {
  visit("input", x.first, input_words())("weight", x.second);
  if (x.first == Input::channel) visit.complain("input", "the range of a channel is that of its terms");
  if (!std::isfinite(x.second) || x.second == 0.0) visit.complain("weight", "a number other than 0 is expected");
}

template <class Visitor, PossiblyConst<Covered> X>
void members(Visitor& visit, X& x) {
  visit("least", x.least)("greatest", x.greatest)("weights", x.weights).optional("noise", x.noise, x.noise != 0.0);
}

template <class Visitor, PossiblyConst<ThermalReading> X>
void members(Visitor& visit, X& x) {
  visit("smoothing", x.smoothing)("lag", x.lag)("start_window", x.start_window);
  visit.optional("averaging", x.averaging, true);
  expect_not_negative(visit, "smoothing", x.smoothing);
  expect_not_negative(visit, "lag", x.lag);
  expect_not_negative(visit, "start_window", x.start_window);
  expect_not_negative(visit, "averaging", x.averaging);
}

template <class Visitor, PossiblyConst<MeasuredDepartures> X>
void members(Visitor& visit, X& x) {
  visit("slope", x.slope)("offset", x.offset)("input", x.input)("departure", x.departure);
  if (x.input.size() != x.departure.size()) visit.complain("departure", "must have as many numbers as input");
}

template <class Visitor, PossiblyConst<OutputModel> X>
void members(Visitor& visit, X& x) {
  visit("role", x.role)("shows", x.shows, input_words())("unit", x.unit)("recorded", x.recorded)("nominal", x.nominal);
  if (x.shows == Input::channel) visit.complain("shows", "an output shows a quantity");
  if (!std::isfinite(x.nominal) || x.nominal == 0.0) visit.complain("nominal", "a number other than 0 is expected");
  if (x.unit.dimension() != Unit::parse(unit_of(x.shows)).dimension())
    visit.complain("unit", say("{} is no unit of {}", Name{x.unit.text()}, Name{name(x.shows)}));
  visit.index("scale", x.scale).index("offset", x.offset).index("spread", x.spread).index("delay", x.delay);
  visit.optional("by_output", x.by_output, x.by_output).optional("misfit", x.misfit, x.misfit != 0.0);
  expect_not_negative(visit, "misfit", x.misfit);
  visit("thermal", x.thermal)("reference_temperature", x.reference_temperature);
  visit.optional("caveats", x.caveats, !x.caveats.empty()).optional("covered", x.covered, !x.covered.empty());
  visit.optional("in_region", x.in_region, x.in_region);
  if (x.in_region && x.covered.empty()) visit.complain("in_region", "needs covered, which says where the model holds");
  visit("measured", x.measured)("terms", x.terms);
}

}  // namespace tumble
