#include "tumble/reduce/imu/error_models.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/reduce/compensation/inputs.hpp"

namespace tumble::imu {
namespace {

/// Pointer to the component of the field that an output shows.
double& (*shown(Kind kind, std::size_t axis))(Felt& felt) {
  const std::string input = fmt::format("{}_{}", kind == Kind::gyro ? "rate" : "specific_force", letters[axis]);
  return std::ranges::find(compensation::inputs(), input, &compensation::Input::name)->of;
}

std::vector<Term> terms_of(const std::string& role) {
  const Model& model = find_model("imu");
  const auto outputs = model.outputs(defaults(model.constants()));
  return std::ranges::find(outputs, role, &Output::channel)->terms;
}

/// Unit of the channel where it shows the quantity itself, else the usual unit.
std::string unit_of(Kind kind, const Channel* channel) {
  const char* usual = kind == Kind::gyro ? "deg/s" : "m/s^2";
  return channel && channel->unit.dimension() == Unit::parse(usual).dimension() ? channel->unit.text() : usual;
}

double scale_of(const Channel* channel) {
  const bool increments = channel && (channel->kind == QuantityKind::angle || channel->kind == QuantityKind::velocity);
  return increments ? samples_per_second(*channel) : 1.0;
}

ErrorModel model_of(const Estimate& estimate, const Recording& recording, Kind kind, std::size_t axis) {
  ErrorModel model;
  model.role = role_of(kind, axis);
  model.shown = shown(kind, axis);
  model.terms = terms_of(model.role);
  const Channel* channel = channel_of(estimate, recording, model.role);
  model.unit = unit_of(kind, channel);
  model.scale = scale_of(channel);
  if (find_parameter(estimate, model.role + "_scale_factor")) {
    model.scale_factor = model.role + "_scale_factor";
    model.offset = model.role + "_bias";
    std::erase_if(model.terms, [&](const Term& term) { return term.name == model.offset; });
  }
  return model;
}

}  // namespace

CalibratedUnit error_models(const Estimate& estimate, const Recording& recording) {
  CalibratedUnit all, recorded;
  for (const Kind kind : kinds) {
    if (!find_parameter(estimate, role_of(kind, 0) + "_bias")) continue;
    bool present = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.outputs.push_back({kind, axis, model_of(estimate, recording, kind, axis)});
      present = present || channel_of(estimate, recording, role_of(kind, axis));
    }
    if (present)
      recorded.outputs.insert(recorded.outputs.end(), all.outputs.end() - 3, all.outputs.end());
    else
      recorded.findings.push_back(
          {Finding::Severity::info, kind == Kind::gyro ? "no_gyros_recorded" : "no_accelerometers_recorded", {}});
  }
  return recorded.outputs.empty() ? all : recorded;
}

Compensation compensate(CalibratedUnit unit, const Estimate& estimate, const Recording& recording, const Plan* plan) {
  std::vector<ErrorModel> models;
  for (auto& output : unit.outputs) models.push_back(std::move(output.model));
  Compensation out = tumble::compensate(models, estimate, recording, plan);
  out.findings.insert(out.findings.begin(), unit.findings.begin(), unit.findings.end());
  return out;
}

}  // namespace tumble::imu
