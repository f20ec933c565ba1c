#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string_view>

#include "bindings.hpp"
#include "recordings.hpp"
#include "tumble/math/stability/allan_family_curve.hpp"
#include "tumble/math/stability/every_tau.hpp"
#include "tumble/units/error.hpp"

namespace tumble::python {
namespace {

template <class T>
nb::ndarray<nb::numpy, T, nb::ndim<1>> array_of(std::vector<T> values) {
  auto* const kept = new std::vector<T>(std::move(values));
  const nb::capsule owner(kept, [](void* it) noexcept { delete static_cast<std::vector<T>*>(it); });
  return {kept->data(), {kept->size()}, owner};
}

using Numbers = nb::ndarray<nb::numpy, double, nb::ndim<1>>;
using Counts = nb::ndarray<nb::numpy, std::int64_t, nb::ndim<1>>;
/// factor, tau [s], deviation, count, alpha, edf, lower, upper
using Columns = std::tuple<Counts, Numbers, Numbers, Counts, Counts, Numbers, Numbers, Numbers>;

/// One column a member of DeviationPoint, in its order.
Columns columns_of(const std::vector<DeviationPoint>& points) {
  const auto column = [&]<class T>(T DeviationPoint::*member) {
    std::vector<T> values;
    for (const auto& point : points) values.push_back(point.*member);
    return values;
  };
  const auto counts = column(&DeviationPoint::count), factors = column(&DeviationPoint::factor);
  const auto alphas = column(&DeviationPoint::alpha);
  return {array_of(std::vector<std::int64_t>(factors.begin(), factors.end())),
          array_of(column(&DeviationPoint::tau)),
          array_of(column(&DeviationPoint::deviation)),
          array_of(std::vector<std::int64_t>(counts.begin(), counts.end())),
          array_of(std::vector<std::int64_t>(alphas.begin(), alphas.end())),
          array_of(column(&DeviationPoint::edf)),
          array_of(column(&DeviationPoint::lower)),
          array_of(column(&DeviationPoint::upper))};
}

struct Request {
  Stability measure = Stability::overlapping_allan;
  bool of_phase = false;
  double rate = 1.0;  ///< [Hz]
  AllanOptions curve;
  std::optional<int> alpha;
};

/// Of rate as the method allan_noise does it; of phase at the given factors, each exactly as it is defined.
std::vector<DeviationPoint> points_of(std::span<const double> values, const Request& request) {
  if (request.of_phase)
    return stability(
        request.measure, values, 1.0 / request.rate, request.curve.factors,
        {.confidence = request.curve.confidence, .alpha = request.alpha, .remove_bias = request.curve.remove_bias});
  auto points = overlapping_allan(values, request.rate, request.curve);
  if (request.measure == Stability::overlapping_allan && !request.alpha) return points;
  if (request.alpha)
    for (auto& point : points) point.alpha = *request.alpha;
  return stability_curve(request.measure, values, request.rate, request.curve, points);
}

Columns deviations(const Samples& samples, const Request& request) {
  std::vector<DeviationPoint> points;
  {
    Unlocked unlocked;
    points = points_of({samples.data(), samples.shape(0)}, request);
  }
  return columns_of(points);
}

/// Every averaging factor 1, 2, 3 ...: deviation [u] and number of terms.
std::pair<Numbers, Counts> every(const Samples& samples, const std::string& kind) {
  EveryTau all;
  {
    Unlocked unlocked;
    const std::span<const double> rate(samples.data(), samples.shape(0));
    all = kind == "ohdev" ? every_overlapping_hadamard(rate) : every_overlapping_allan(rate);
  }
  return {array_of(std::move(all.deviation)), array_of(std::vector<std::int64_t>(all.count.begin(), all.count.end()))};
}

}  // namespace

void bind_stability(nb::module_& module) {
  using namespace nb::literals;
  nb::enum_<Stability>(module, "Stability")
      .value("adev", Stability::allan)
      .value("oadev", Stability::overlapping_allan)
      .value("mdev", Stability::modified_allan)
      .value("tdev", Stability::time)
      .value("hdev", Stability::hadamard)
      .value("ohdev", Stability::overlapping_hadamard)
      .value("totdev", Stability::total)
      .value("mtotdev", Stability::modified_total)
      .value("ttotdev", Stability::time_total)
      .value("htotdev", Stability::hadamard_total)
      .value("pdev", Stability::parabolic)
      .value("theo1", Stability::theo1)
      .value("theoh", Stability::theoh)
      .value("mtie", Stability::peak_interval_error)
      .value("tierms", Stability::rms_interval_error);
  module.def("averaging_factors", &averaging_factors, "longest"_a, "points_per_decade"_a);
  module.def(
      "deviations",
      [](const Samples& samples, Stability measure, double rate, bool of_phase, std::vector<std::size_t> factors,
         double points_per_decade, double longest_fraction, double confidence, std::optional<int> alpha,
         bool remove_bias, bool subtract_mean_rate) {
        const AllanOptions curve{.points_per_decade = points_per_decade,
                                 .confidence = confidence,
                                 .longest_fraction = longest_fraction,
                                 .factors = std::move(factors),
                                 .remove_bias = remove_bias,
                                 .subtract_mean_rate = subtract_mean_rate};
        return deviations(samples, {measure, of_phase, rate, curve, alpha});
      },
      "samples"_a.noconvert(), "measure"_a, "rate"_a, "of_phase"_a, "factors"_a, "points_per_decade"_a,
      "longest_fraction"_a, "confidence"_a, "alpha"_a.none(), "remove_bias"_a, "subtract_mean_rate"_a);
  module.def("every", &every, "samples"_a.noconvert(), "kind"_a);
}

}  // namespace tumble::python
