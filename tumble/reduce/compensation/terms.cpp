#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/reduce/compensation/work.hpp"
#include "tumble/units/error.hpp"

namespace tumble::compensation {
namespace {

double value_of(const UsedFactor& used, const Values& values, double& state) {
  double x = values[used.slot] - used.origin;
  if (used.linear) return x;
  if (used.start != SIZE_MAX) x -= values[used.start];
  if (std::isnan(state)) state = x;
  return tumble::value_of(used.form, used.order, used.size, x, state);
}

/// Number of the slot of an input; added where there is none yet.
std::size_t slot_of(const Slot& wanted, std::vector<Slot>& slots) {
  const auto match = std::ranges::find_if(slots, [&](const Slot& slot) {
    return slot.input == wanted.input && slot.role == wanted.role && slot.lag == wanted.lag && slot.base == wanted.base;
  });
  const auto index = static_cast<std::size_t>(match - slots.begin());
  if (index == slots.size()) slots.push_back(wanted);
  return index;
}

UsedFactor used_factor(const TermFactor& factor, const Estimate& estimate, std::vector<Slot>& slots) {
  UsedFactor used{.form = factor.form, .order = factor.order, .origin = factor.origin, .size = factor.size};
  used.slot = slot_of({factor.input, factor.role}, slots);
  if (factor.lag)
    used.slot = slot_of({factor.input, factor.role, estimate.parameters.at(*factor.lag).value, used.slot}, slots);
  if (factor.from_start) used.start = static_cast<std::size_t>(Input::start_temperature);
  used.linear = factor.form == TermFactor::Form::power && factor.order == 1 && !factor.from_start;
  return used;
}

UsedTerm used_term(const ModelTerm& term, const Estimate& estimate, std::vector<Slot>& slots) {
  UsedTerm used{.name = term.term, .least = term.least, .greatest = term.greatest, .per_output = term.per_output};
  if (term.parameter) {
    used.parameter = *term.parameter;
    used.coefficient = estimate.parameters.at(used.parameter).value;
  }
  for (const Product& product : term.regressor) {
    UsedProduct& out = used.products.emplace_back(UsedProduct{product.weight, {}});
    for (const TermFactor& factor : product.factors) {
      out.factors.push_back(used_factor(factor, estimate, slots));
      used.has_play = used.has_play || factor.form == TermFactor::Form::play;
      used.slots.insert(out.factors.back().slot);
      if (out.factors.back().start != SIZE_MAX) used.slots.insert(out.factors.back().start);
    }
  }
  return used;
}

bool is_linear(const UsedTerm& term) {
  return std::ranges::all_of(term.products, [](const UsedProduct& product) {
    return product.factors.empty() || (product.factors.size() == 1 && product.factors[0].linear);
  });
}

void add_linear(const UsedTerm& term, double coefficient, LinearPart& linear) {
  for (const UsedProduct& product : term.products) {
    const double slope = coefficient * product.weight;
    if (product.factors.empty()) linear.constant += slope;
    if (product.factors.empty()) continue;
    linear.constant -= slope * product.factors[0].origin;
    linear.slopes[product.factors[0].slot] += slope;
  }
}

}  // namespace

void sort_by_slots(Work& work, std::size_t slot_count) {
  work.terms_with.assign(slot_count, {});
  work.curved_with.assign(slot_count, {});
  work.linear.slopes.assign(slot_count, 0.0);
  std::set<std::size_t> slots;
  for (std::size_t j = 0; j < work.terms.size(); ++j) {
    const UsedTerm& term = work.terms[j];
    const bool linear = is_linear(term);
    for (const std::size_t slot : term.slots) work.terms_with[slot].push_back(j);
    if (linear) {
      add_linear(term, term.coefficient / (term.per_output ? work.scale_factor : 1.0), work.linear);
      slots.insert(term.slots.begin(), term.slots.end());
    } else {
      work.curved.push_back(j);
      for (const std::size_t slot : term.slots) work.curved_with[slot].push_back(j);
    }
  }
  for (const std::size_t slot : slots) work.linear.of_slots.emplace_back(slot, work.linear.slopes[slot]);
}

double regressor_of(const UsedTerm& term, const Values& values) {
  double sum = 0.0;
  for (const UsedProduct& product : term.products) {
    double value = product.weight;
    for (const UsedFactor& used : product.factors) {
      double state = used.state;
      value *= value_of(used, values, state);
    }
    sum += value;
  }
  return sum;
}

void advance(UsedTerm& term, const Values& values) {
  if (!term.has_play) return;
  for (UsedProduct& product : term.products)
    for (UsedFactor& used : product.factors) value_of(used, values, used.state);
}

void begin(UsedTerm& term) {
  for (UsedProduct& product : term.products)
    for (UsedFactor& used : product.factors) used.state = std::nan("");
}

std::vector<UsedTerm> used_terms(const OutputModel& model, const Estimate& estimate, std::vector<Slot>& slots) {
  Problems faults;
  std::vector<UsedTerm> out;
  for (const ModelTerm& term : model.terms) {
    out.push_back(used_term(term, estimate, slots));
    for (const Product& product : term.regressor)
      for (const TermFactor& factor : product.factors)
        if (factor.lag && !(estimate.parameters.at(*factor.lag).value >= 0.0))
          faults.push_back(
              say("the result's parameter '{}' is no time constant", estimate.parameters[*factor.lag].name));
    if (!std::isfinite(out.back().coefficient))
      faults.push_back(say("the result's parameter '{}' has no value", term.term));
  }
  if (!faults.empty()) throw Error(Error::Kind::bad_file, faults);
  return out;
}

}  // namespace tumble::compensation
