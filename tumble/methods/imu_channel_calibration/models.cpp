#include <fmt/format.h>

#include "tumble/methods/imu_channel_calibration/compare.hpp"
#include "tumble/reduce/imu/error_models.hpp"
#include "tumble/reduce/output_model.hpp"

namespace tumble::imu_channel_calibration {
namespace {

/// A_i = y_i - (nabla_i - dK_i y_i - E_ij y_j - E_il y_l), y = N/(K_m H): what is subtracted, term by term.
TermRanges subtracted(const Pair& pair, std::size_t axis) {
  const std::string role = role_of(pair.kind, axis);
  const Input first = pair.kind == Kind::gyro ? Input::rate_x : Input::specific_force_x;
  TermRanges ranges;
  const auto add = [&](const std::string& name, Regressor regressor, double least, double greatest) {
    ranges.terms.push_back({name, "", "", "", std::move(regressor)});
    ranges.least.push_back(least);
    ranges.greatest.push_back(greatest);
  };
  add(role + "_bias", 1.0, 1.0, 1.0);
  for (const std::size_t which : {1u, 2u, 3u}) {
    const std::size_t of = which == 1 ? axis : other_axis(axis, which), i = index_of(axis, which);
    add(role + (which == 1 ? std::string("_scale_factor_error") : fmt::format("_misalignment_{}", letters[of])),
        -along(first, of), -pair.whole.greatest[i], -pair.whole.least[i]);
  }
  return ranges;
}

}  // namespace

std::vector<OutputModel> models_of(const std::vector<Pair>& pairs, const Evidence& whole, const Estimate& estimate) {
  std::vector<OutputModel> models;
  for (const Pair& pair : pairs)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool gyro = pair.kind == Kind::gyro;
      const std::string role = role_of(pair.kind, axis);
      const Input shows = along(gyro ? Input::rate_x : Input::specific_force_x, axis);
      OutputModel model = output_model(estimate, role, shows, gyro ? "deg/s" : "m/s^2", subtracted(pair, axis));
      model.by_output = true;
      if (const Channel* channel = channel_for(whole, whole.recordings.front(), role))
        set_reading(*channel, reading_of(pair.kind, whole.plan.settings, *channel).scale, model);
      models.push_back(std::move(model));
    }
  return models;
}

}  // namespace tumble::imu_channel_calibration
