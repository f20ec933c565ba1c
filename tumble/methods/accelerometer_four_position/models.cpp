#include "tumble/methods/accelerometer_four_position/report.hpp"
#include "tumble/reduce/accelerometer/output.hpp"
#include "tumble/reduce/accelerometer/over_temperature.hpp"
#include "tumble/reduce/output_model.hpp"

namespace tumble::accelerometer_four_position {

OutputModel model_of(const Bench& bench, const Evidence& evidence, const Estimate& estimate) {
  OutputModel model =
      accelerometer::over_temperature(estimate, bench.group_temperature.front(), bench.group_temperature.back());
  if (bench.group_temperature.size() > 1)
    model.reference_temperature = evidence.plan.settings.number("report_temperature");
  const Channel& channel = require_channel(evidence, evidence.recordings.front(), "accelerometer");
  set_reading(channel, accelerometer::scale_of(evidence.plan.settings, channel), model);
  return model;
}

}  // namespace tumble::accelerometer_four_position
