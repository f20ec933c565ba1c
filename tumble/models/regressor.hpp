#pragma once

#include <concepts>
#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

#include "tumble/core/error_model.hpp"

namespace tumble {

struct Felt;

/// The regressor of a term: a sum of products of functions of what is felt, as data that a result can carry. What
/// cannot be written so is a function, which no result carries.
///
///   f_x * f_y,   0.5 * magnitude(w_x),   decay(t, 300.0)
class Regressor {
 public:
  Regressor() = default;
  /// A constant [SI], whatever is felt.
  Regressor(double constant);  // NOLINT(google-explicit-constructor): 1.0 is a regressor
  /// The input itself [SI].
  Regressor(Input input);        // NOLINT(google-explicit-constructor)
  Regressor(TermFactor factor);  // NOLINT(google-explicit-constructor)
  explicit Regressor(const std::vector<Product>& products);
  /// A function [SI] of what is felt.
  template <class Function>
  requires(std::is_invocable_r_v<double, Function, const Felt&> && !std::same_as<std::decay_t<Function>, Regressor>)
      Regressor(Function function)
      : function_(std::move(function)) {}  // NOLINT(google-explicit-constructor)

  /// Value [SI] at one instant.
  double operator()(const Felt& felt) const;
  /// Empty where it is a function, and of the regressor 0.
  const std::vector<Product>& products() const { return products_; }
  explicit operator bool() const { return function_ || !products_.empty(); }

 private:
  /// One factor with what a sample needs of it: the products one after the other, without names.
  struct Step {
    TermFactor::Form form = TermFactor::Form::power;
    int order = 0;  ///< 0: a constant product
    std::size_t input = 0;
    bool from_start = false, begins = false, ends = false;  ///< its product
    double weight = 1.0;                                    ///< of its product
    double origin = 0.0, size = 1.0;
  };
  std::vector<Product> products_;
  std::vector<Step> steps_;
  std::function<double(const Felt&)> function_;
};

Regressor operator*(const Regressor& a, const Regressor& b);
Regressor operator+(const Regressor& a, const Regressor& b);
Regressor operator-(const Regressor& a, const Regressor& b);
Regressor operator-(const Regressor& a);
inline Regressor operator*(Input a, Input b) { return Regressor(a) * Regressor(b); }
inline Regressor operator-(Input a) { return -Regressor(a); }
/// x^n.
Regressor power(const Regressor& x, int n);
/// |x| [SI of x].
Regressor magnitude(Input x);
/// exp(-x/size), `size` [SI of x].
Regressor decay(Input x, double size);
/// x - origin [SI of x], and less the start temperature too.
Regressor from(Input x, double origin);
Regressor from_start(Input x);

/// A factor of `x` [SI of the input]. Given: n, size [SI of the input], and for `play` the state before this sample, which
/// it changes.
double value_of(TermFactor::Form form, int order, double size, double x, double& state);

/// Component 0, 1 or 2 of the vector whose first component is `x`.
constexpr Input along(Input x, std::size_t axis) { return static_cast<Input>(static_cast<std::size_t>(x) + axis); }

}  // namespace tumble
