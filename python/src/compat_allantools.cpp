#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <tuple>

#include "bindings.hpp"
#include "clock_intervals.hpp"
#include "frequency_stability.hpp"
#include "recordings.hpp"

namespace tumble::python {
namespace {

using Numbers = nb::ndarray<nb::numpy, double, nb::ndim<1>>;
using Columns = std::tuple<Numbers, Numbers, Numbers, Numbers>;  ///< taus, devs, errs, ns

std::span<const double> span_of(const Samples& samples) { return {samples.data(), samples.shape(0)}; }
Taus taus_of(const std::string& word) { return word; }
Taus taus_of(const Samples& times) { return std::vector<double>(times.data(), times.data() + times.shape(0)); }

template <class T>
nb::capsule owner_of(T* kept) {
  return {kept, [](void* it) noexcept { delete static_cast<T*>(it); }};
}

/// Four arrays of one owner.
Columns columns_of(Deviations found) {
  auto* const it = new Deviations(std::move(found));
  const nb::capsule owner = owner_of(it);
  const auto array = [&](std::vector<double>& values) { return Numbers(values.data(), {values.size()}, owner); };
  return {array(it->taus), array(it->devs), array(it->errs), array(it->ns)};
}

template <class Given>
Columns deviations_at(const Samples& samples, Stability measure, double rate, bool of_phase, const Given& taus) {
  const Taus wanted = taus_of(taus);
  Deviations found;
  {
    Unlocked unlocked;
    found = deviations(measure, span_of(samples), rate, of_phase, wanted);
  }
  return columns_of(std::move(found));
}

/// Four arrays, and the upper limits; errs are the lower ones.
template <class Given>
std::pair<Columns, Numbers> gap_robust_at(const Samples& samples, double rate, bool of_phase, const Given& taus,
                                          double ci, int alpha) {
  const Taus wanted = taus_of(taus);
  Deviations found;
  {
    Unlocked unlocked;
    found = gap_robust(span_of(samples), rate, of_phase, wanted, ci, alpha);
  }
  auto* const kept = new std::vector<double>(std::move(found.upper));
  const nb::capsule owner = owner_of(kept);
  const Numbers upper(kept->data(), {kept->size()}, owner);
  return {columns_of(std::move(found)), upper};
}

template <class Given>
Columns codeviation_at(const Samples& one, const Samples& two, double rate, bool of_phase, const Given& taus) {
  const Taus wanted = taus_of(taus);
  Deviations found;
  {
    Unlocked unlocked;
    found = codeviation(span_of(one), span_of(two), rate, of_phase, wanted);
  }
  return columns_of(std::move(found));
}

template <class Given>
void bind_with(nb::module_& module) {
  using namespace nb::literals;
  module.def("clock_deviations", &deviations_at<Given>, "samples"_a.noconvert(), "measure"_a, "rate"_a, "of_phase"_a,
             "taus"_a);
  module.def("clock_gap_robust", &gap_robust_at<Given>, "samples"_a.noconvert(), "rate"_a, "of_phase"_a, "taus"_a,
             "ci"_a, "alpha"_a);
  module.def(
      "clock_factors",
      [](const Given& taus, double rate, std::size_t points, double longest, bool even) {
        return factors_of(taus_of(taus), rate, points, longest, even);
      },
      "taus"_a, "rate"_a, "points"_a, "longest"_a, "even"_a);
  module.def("clock_codeviation", &codeviation_at<Given>, "one"_a.noconvert(), "two"_a.noconvert(), "rate"_a,
             "of_phase"_a, "taus"_a);
}

}  // namespace

void bind_compat_allantools(nb::module_& module) {
  using namespace nb::literals;
  bind_with<std::string>(module);
  bind_with<Samples>(module);
  module.def("chi_square_limits", &chi_square_limits, "deviation"_a, "edf"_a, "ci"_a);
  module.def("simple_edf", &simple_edf, "points"_a, "factor"_a, "alpha"_a);
}

}  // namespace tumble::python
