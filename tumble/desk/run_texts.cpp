#include "tumble/desk/run_texts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

const Unit& shown_unit(StationAxis::Kind kind, bool rate) {
  static const Unit angle = Unit::parse("deg"), angle_rate = Unit::parse("deg/s"), air = Unit::parse("degC"),
                    air_rate = Unit::parse("K/min"), force = Unit::parse("m/s^2");
  if (kind == StationAxis::Kind::temperature) return rate ? air_rate : air;
  if (kind == StationAxis::Kind::acceleration) return force;
  return rate ? angle_rate : angle;
}

std::string text_in(const std::optional<double>& value, const Unit& unit) {
  return value && std::isfinite(*value) ? fmt::format("{:.6g} {}", unit.from_si(*value), unit.text()) : "";
}

}  // namespace

AxisTexts texts_of(const RunView::AxisView& axis) {
  using Demand = AxisProgress::Demand;
  const bool none = axis.demand == Demand::none || axis.demand == Demand::rest;
  return {none ? "" : text_in(axis.demanded, shown_unit(axis.kind, axis.demand == Demand::rate)),
          text_in(axis.temperature ? axis.temperature : axis.position, shown_unit(axis.kind, false)),
          text_in(axis.rate, shown_unit(axis.kind, true))};
}

bool is_everyday(EventKind kind, std::optional<RunPhase> entered) {
  return kind == EventKind::phase && entered != RunPhase::faulted && entered != RunPhase::paused;
}

std::string hours_text(double seconds) {
  constexpr auto an_hour = static_cast<long>(hour);
  const auto whole = static_cast<long>(std::max(0.0, seconds));
  return fmt::format("{}:{:02}:{:02}", whole / an_hour, whole / 60 % 60, whole % 60);
}

}  // namespace tumble
