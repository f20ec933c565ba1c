#include <fmt/format.h>

#include "tumble/methods/imu_channel_calibration/compare.hpp"
#include "tumble/reduce/imu/error_models.hpp"

namespace tumble::imu_channel_calibration {
namespace {

/// A_i = y_i - (nabla_i - dK_i y_i - E_ij y_j - E_il y_l), y = N/(K_m H): what is subtracted, term by term.
std::vector<Term> subtracted_terms(Kind kind, std::size_t axis) {
  const std::string role = role_of(kind, axis);
  const auto output = [=](std::size_t of) {
    return [=](const Felt& felt) { return -imu::component(imu::field_of(kind, felt), of); };
  };
  std::vector<Term> all{{role + "_bias", "", "", "", [](const Felt&) { return 1.0; }},
                        {role + "_scale_factor_error", "", "", "", output(axis)}};
  for (const std::size_t which : {2u, 3u}) {
    const std::size_t other = other_axis(axis, which);
    all.push_back({fmt::format("{}_misalignment_{}", role, letters[other]), "", "", "", output(other)});
  }
  return all;
}

}  // namespace

Table covered(const std::vector<Pair>& pairs) {
  std::vector<Term> all;
  std::vector<double> least, greatest;
  for (const Pair& pair : pairs)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::size_t a = 0;
      for (Term& term : subtracted_terms(pair.kind, axis)) {
        const std::size_t i = index_of(axis, a);
        least.push_back(a == 0 ? 1.0 : -pair.whole.greatest[i]);
        greatest.push_back(a == 0 ? 1.0 : -pair.whole.least[i]);
        all.push_back(std::move(term));
        ++a;
      }
    }
  return regressors_table(all, least, greatest);
}

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan,
                        const std::vector<Option>& options) {
  const Settings settings = settings_of(estimate, options);
  auto calibrated = imu::error_models(estimate, recording);
  for (auto& [kind, axis, model] : calibrated.outputs) {
    model.by_output = true;
    model.terms = subtracted_terms(kind, axis);
    if (const Channel* channel = channel_of(estimate, recording, model.role))
      model.scale = reading_of(kind, settings, *channel).scale;
  }
  return imu::compensate(std::move(calibrated), estimate, recording, plan);
}

}  // namespace tumble::imu_channel_calibration
