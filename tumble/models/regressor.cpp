#include "tumble/models/regressor.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tumble/models/model.hpp"

namespace tumble {
namespace {

bool is_power_of_same(const TermFactor& a, const TermFactor& b) {
  return a.form == TermFactor::Form::power && b.form == a.form && a.input == b.input && a.role == b.role &&
         a.origin == b.origin && a.from_start == b.from_start && a.lag == b.lag;
}

double powered(double value, double x, int n) {
  for (int k = 0; k < n; ++k) value *= x;
  return value;
}

}  // namespace

Regressor::Regressor(double constant)
    : Regressor(constant == 0.0 ? std::vector<Product>{} : std::vector<Product>{{constant, {}}}) {}
Regressor::Regressor(Input input) : Regressor(TermFactor{.input = input}) {}
Regressor::Regressor(TermFactor factor) : Regressor(std::vector<Product>{{1.0, {std::move(factor)}}}) {}
Regressor::Regressor(const std::vector<Product>& products) : products_(products) {
  for (const Product& product : products_) {
    const std::size_t first = steps_.size();
    if (product.factors.empty()) steps_.push_back({.weight = product.weight});
    for (const TermFactor& factor : product.factors)
      steps_.push_back({.form = factor.form,
                        .order = factor.order,
                        .input = static_cast<std::size_t>(factor.input),
                        .from_start = factor.from_start,
                        .weight = product.weight,
                        .origin = factor.origin,
                        .size = factor.size});
    steps_[first].begins = steps_.back().ends = true;
  }
}

double Regressor::operator()(const Felt& felt) const {
  if (function_) return function_(felt);
  static_assert(sizeof(Felt) == felt_inputs * sizeof(double));
  double sum = 0.0, value = 0.0;
  for (const Step& step : steps_) {
    if (step.begins) value = step.weight;
    if (step.order != 0 || step.form != TermFactor::Form::power) {
      double x = 0.0;
      std::memcpy(&x, reinterpret_cast<const char*>(&felt) + step.input * sizeof(double), sizeof x);
      x -= step.origin;
      if (step.from_start) x -= felt.start_temperature;
      double state = x;
      value = step.form == TermFactor::Form::power ? powered(value, x, step.order)
                                                   : value * value_of(step.form, step.order, step.size, x, state);
    }
    if (step.ends) sum += value;
  }
  return sum;
}

double value_of(TermFactor::Form form, int order, double size, double x, double& state) {
  switch (form) {
    case TermFactor::Form::power:
      return powered(1.0, x, order);
    case TermFactor::Form::magnitude:
      return std::abs(x);
    case TermFactor::Form::sine:
      return std::sin(order * x);
    case TermFactor::Form::cosine:
      return std::cos(order * x);
    case TermFactor::Form::decay:
      return std::exp(-x / size);
    case TermFactor::Form::play:
      return state = std::max(x - size, std::min(x + size, state));
  }
  return 0.0;
}

Regressor operator*(const Regressor& a, const Regressor& b) {
  std::vector<Product> products;
  for (const Product& one : a.products())
    for (const Product& other : b.products()) {
      Product product{one.weight * other.weight, one.factors};
      for (const TermFactor& factor : other.factors)
        if (!product.factors.empty() && is_power_of_same(product.factors.back(), factor))
          product.factors.back().order += factor.order;
        else
          product.factors.push_back(factor);
      products.push_back(std::move(product));
    }
  return Regressor(std::move(products));
}

Regressor operator+(const Regressor& a, const Regressor& b) {
  auto products = a.products();
  products.insert(products.end(), b.products().begin(), b.products().end());
  return Regressor(std::move(products));
}

Regressor operator-(const Regressor& a) { return -1.0 * a; }
Regressor operator-(const Regressor& a, const Regressor& b) { return a + -b; }

Regressor power(const Regressor& x, int n) {
  Regressor product = 1.0;
  for (int k = 0; k < n; ++k) product = product * x;
  return product;
}

Regressor magnitude(Input x) { return TermFactor{.input = x, .form = TermFactor::Form::magnitude}; }
Regressor decay(Input x, double size) { return TermFactor{.input = x, .form = TermFactor::Form::decay, .size = size}; }
Regressor from(Input x, double origin) { return TermFactor{.input = x, .origin = origin}; }
Regressor from_start(Input x) { return TermFactor{.input = x, .from_start = true}; }

}  // namespace tumble
