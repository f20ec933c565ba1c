#include "tumble/reduce/output_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>

#include "tumble/clocks/sampling_rate.hpp"

namespace tumble {
namespace {

/// "pulse/s" of pulses; brackets where the unit is an expression itself.
Unit per_second(const Unit& unit) {
  const std::string& text = unit.text();
  const bool plain = std::ranges::all_of(text, [](char c) { return std::isalpha(static_cast<unsigned char>(c)); });
  return Unit::parse(plain ? text + "/s" : "(" + text + ")/s");
}

}  // namespace

std::optional<std::size_t> parameter_index(const Estimate& estimate, std::string_view name) {
  const auto match = std::ranges::find(estimate.parameters, name, &Parameter::name);
  if (match == estimate.parameters.end()) return std::nullopt;
  return static_cast<std::size_t>(match - estimate.parameters.begin());
}

OutputModel output_model(const Estimate& estimate, const std::string& role, Input shows, const std::string& unit,
                         const TermRanges& ranges) {
  OutputModel model{.role = role, .shows = shows, .unit = Unit::parse(unit)};
  model.recorded = model.unit;
  for (std::size_t j = 0; j < ranges.terms.size(); ++j) {
    const auto parameter = parameter_index(estimate, ranges.terms[j].name);
    const auto& products = ranges.terms[j].regressor.products();
    if (!parameter || products.empty()) continue;
    model.terms.push_back({ranges.terms[j].name, parameter, products, ranges.least[j], ranges.greatest[j]});
  }
  return model;
}

void set_scale(const Estimate& estimate, const std::string& name, OutputModel& model) {
  model.scale = parameter_index(estimate, name);
  if (!model.scale) return;
  std::erase_if(model.terms, [&](const ModelTerm& term) { return term.term == name; });
  const Unit& factor = estimate.parameters[*model.scale].unit;
  model.recorded =
      factor.text().empty() ? model.unit : Unit::parse(fmt::format("({})*({})", factor.text(), model.unit.text()));
  model.nominal = 1.0;
}

void set_reading(const Channel& channel, double scale, OutputModel& model) {
  const bool integral = channel.kind == QuantityKind::count || channel.kind == QuantityKind::angle ||
                        channel.kind == QuantityKind::velocity;
  model.recorded = integral ? per_second(channel.unit) : channel.unit;
  model.nominal = integral ? scale / sampling_rate(channel) : scale;
}

TermRanges ranges_over(std::vector<Term> terms, const std::vector<Felt>& felt) {
  TermRanges ranges{std::move(terms), {}, {}};
  for (const Term& term : ranges.terms) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Felt& one : felt) {
      const double x = term.regressor(one);
      low = std::min(low, x), high = std::max(high, x);
    }
    ranges.least.push_back(low);
    ranges.greatest.push_back(high);
  }
  return ranges;
}

}  // namespace tumble
