#include "tumble/desk/desk_lines/run_json.hpp"

#include <cmath>

#include "tumble/desk/run_texts.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::desk_lines {
namespace {

/// Seven digits are more than any screen shows; null where it is not a number.
Json drawn(double value) {
  if (!std::isfinite(value)) return nullptr;
  return rounded_to_digits(value, 7) + 0.0;  // no minus before zero
}

Json drawn(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(drawn(value));
  return list;
}

std::string text_of(double value, int digits) { return std::isfinite(value) ? general(value, digits) : ""; }

template <class Bars>
Json bars_of(const Bars& bars) {
  Json list = Json::array();
  for (const CurveBar& bar : bars) list.push_back({drawn(bar.time), drawn(bar.low), drawn(bar.high)});
  return list;
}

const char* step_of(RunRow::Kind kind) {
  switch (kind) {
    case RunRow::Kind::power_up:
      return "power_up";
    case RunRow::Kind::segment_begins:
      return "begins";
    case RunRow::Kind::segment_ends:
      return "ends";
    case RunRow::Kind::unit_out:
      return "unit_out";
    case RunRow::Kind::run_ends:
      return "run_ends";
    case RunRow::Kind::records:
      return "records";
    case RunRow::Kind::pauses:
      return "pauses";
  }
  return "";
}

Json json_of(const RunView::AxisView& axis) {
  const AxisTexts texts = texts_of(axis);
  return {{"name", axis.name}, {"demanded", texts.demanded}, {"position", texts.position}, {"rate", texts.rate}};
}

Json json_of(const RunView::ChannelView& channel) {
  return {{"slot", channel.slot},
          {"name", channel.name},
          {"unit", channel.unit.text()},
          {"mean", text_of(channel.unit.from_si(channel.mean), 6)},
          {"sd", text_of(channel.unit.difference_from_si(channel.sd), 3)},
          {"allan", text_of(channel.unit.difference_from_si(channel.allan), 3)},
          {"low", drawn(channel.unit.from_si(channel.low))},
          {"high", drawn(channel.unit.from_si(channel.high))}};
}

Json json_of(const RunView::EstimateView& estimate) {
  const double value = estimate.unit.from_si(estimate.value), sd = estimate.unit.difference_from_si(estimate.sd);
  return {{"slot", estimate.slot},
          {"name", estimate.name},
          {"unit", estimate.unit.text()},
          {"text", with_uncertainty(value, sd)},
          {"low", drawn(value - sd)},
          {"high", drawn(value + sd)},
          {"sd", drawn(sd)}};
}

template <class View>
Json list_of(const std::vector<View>& views) {
  Json list = Json::array();
  for (const View& view : views) list.push_back(json_of(view));
  return list;
}

}  // namespace

void put_said(Json& json, const std::string& member, const Sentence& said) {
  json[member] = said.text();
  if (const auto values = sentence_to_json(said); !values.empty()) json[member + "_said"] = Json::parse(values);
}

Json json_of(const RunView& view, double speed) {
  Json json{{"time", drawn(view.time)},
            {"time_text", hours_text(view.time)},
            {"phase", name(view.phase)},
            {"segment", view.segment},
            {"segments", json_of(view.progress, view.segment)},
            {"label", view.label},
            {"recorded", drawn(view.recorded)},
            {"left", drawn(view.left)},
            {"left_text", hours_text(view.left)},
            {"wall_left", drawn(view.left / speed)},
            {"acknowledged_text", hours_text(view.acknowledged)},
            {"behind", drawn((view.time - view.acknowledged) / speed)},
            {"frames", view.frames},
            {"lost", view.lost},
            {"damaged", view.damaged},
            {"axes", list_of(view.axes)},
            {"channels", list_of(view.channels)},
            {"estimates", list_of(view.estimates)}};
  if (view.prompt) {
    Json prompt{{"id", view.prompt->id}};
    put_said(prompt, "text", view.prompt->text);
    prompt["choices"] = view.prompt->choices;
    prompt["standard"] = view.prompt->standard;
    json["prompt"] = std::move(prompt);
  }
  return json;
}

Json json_of(const Curves& curves) {
  return {{"recent", bars_of(curves.recent())}, {"whole", bars_of(curves.whole())}};
}

Json json_of(const EstimateHistory& history) {
  Json list = Json::array();
  for (const auto& curve : history.curves()) {
    Json points = Json::array();
    for (const auto& point : curve.points)
      points.push_back(
          {drawn(point.time), drawn(point.value - point.sd), drawn(point.value + point.sd), drawn(point.sd)});
    list.push_back({{"slot", curve.slot}, {"name", curve.name}, {"unit", curve.unit}, {"points", points}});
  }
  return list;
}

Json json_of(std::uint64_t sequence, const StoreEvent& event) {
  Json json{{"id", sequence},
            {"time", drawn(event.time)},
            {"time_text", hours_text(event.time)},
            {"kind", name(event.kind)},
            {"who", event.who}};
  put_said(json, "text", event.text);
  if (is_everyday(event.kind, event.phase)) json["everyday"] = true;
  return json;
}

Json json_of(std::uint64_t sequence, double time, const RunRow& row) {
  Json json{{"id", sequence},
            {"time", drawn(time)},
            {"time_text", hours_text(time)},
            {"kind", "journal"},
            {"who", ""},
            {"text", row.label},
            {"step", step_of(row.kind)},
            {"segment", row.segment},
            {"attempt", row.attempt},
            {"ending", name(row.ending)}};
  put_said(json, "reason", row.reason);
  return json;
}

bool is_shown(const StoreItem& item) {
  return item.event ||
         (item.journal && item.journal->kind != RunRow::Kind::records && item.journal->kind != RunRow::Kind::pauses);
}

Json json_of(const StoreItem& item) {
  if (item.journal) return json_of(item.sequence, item.time, *item.journal);
  return item.event ? json_of(item.sequence, *item.event) : Json();
}

Json json_of(const RunFacts& facts) {
  Json segments = Json::array();
  for (const auto& segment : facts.segments)
    segments.push_back({{"label", segment.label},
                        {"duration", drawn(segment.duration)},
                        {"duration_text", hours_text(segment.duration)},
                        {"rule", segment.rule}});
  return {{"title", facts.title}, {"station", facts.station}, {"operator", facts.who},
          {"rig", facts.rig},     {"units", facts.units},     {"segments", segments}};
}

Json json_of(const std::vector<SegmentProgress>& progress, std::size_t now) {
  using Status = SegmentProgress::Status;
  Json list = Json::array();
  for (std::size_t s = 0; s < progress.size(); ++s) {
    const char* const state = progress[s].status == Status::complete  ? "done"
                              : progress[s].status == Status::skipped ? "skipped"
                              : s == now                              ? "now"
                                                                      : "next";
    list.push_back({{"state", state}, {"attempts", progress[s].attempts}});
  }
  return list;
}

}  // namespace tumble::desk_lines
