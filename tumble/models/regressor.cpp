#include "tumble/models/regressor.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

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

Regressor::Regressor(double constant) {
  if (constant != 0.0) products_ = {{constant, {}}};
}
Regressor::Regressor(Input input) : products_{{1.0, {TermFactor{.input = input}}}} {}
Regressor::Regressor(TermFactor factor) : products_{{1.0, {std::move(factor)}}} {}
Regressor::Regressor(std::vector<Product> products) : products_(std::move(products)) {}

double Regressor::operator()(const Felt& felt) const {
  if (function_) return function_(felt);
  static_assert(sizeof(Felt) == felt_inputs * sizeof(double));
  const auto inputs = std::bit_cast<std::array<double, felt_inputs>>(felt);
  const double start = felt.start_temperature;
  double sum = 0.0;
  for (const Product& product : products_) {
    double value = product.weight;
    for (const TermFactor& factor : product.factors) {
      double x = inputs[static_cast<std::size_t>(factor.input)] - factor.origin;
      if (factor.from_start) x -= start;
      if (factor.form == TermFactor::Form::power) {
        value = powered(value, x, factor.order);
      } else {
        double state = x;
        value *= value_of(factor, x, state);
      }
    }
    sum += value;
  }
  return sum;
}

double value_of(const TermFactor& factor, double x, double& state) {
  switch (factor.form) {
    case TermFactor::Form::power:
      return powered(1.0, x, factor.order);
    case TermFactor::Form::magnitude:
      return std::abs(x);
    case TermFactor::Form::sine:
      return std::sin(factor.order * x);
    case TermFactor::Form::cosine:
      return std::cos(factor.order * x);
    case TermFactor::Form::decay:
      return std::exp(-x / factor.size);
    case TermFactor::Form::play:
      return state = std::max(x - factor.size, std::min(x + factor.size, state));
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
