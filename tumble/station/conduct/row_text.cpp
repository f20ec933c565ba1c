#include "tumble/station/conduct/row_text.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tumble/units/error.hpp"

namespace tumble::conduct {

using Json = nlohmann::json;

std::string text_of(const RunRow& row) {
  Json json{{"kind", static_cast<int>(row.kind)},
            {"time", row.time},
            {"segment", row.segment},
            {"run", row.run},
            {"attempt", row.attempt},
            {"label", row.label},
            {"ending", row.ending},
            {"reason", row.reason},
            {"demanded", row.demanded},
            {"achieved", row.achieved},
            {"rule", row.rule},
            {"at_least", row.at_least}};
  if (row.reached) json["reached"] = *row.reached;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

RunRow row_of(const std::string& text) try {
  const Json json = Json::parse(text);
  RunRow row;
  const int kind = json.at("kind");
  if (kind < 0 || kind > static_cast<int>(RunRow::Kind::run_ends))
    throw Error(Error::Kind::bad_file, "a row of the journal has an unknown kind");
  row.kind = static_cast<RunRow::Kind>(kind);
  json.at("time").get_to(row.time);
  json.at("segment").get_to(row.segment);
  json.at("run").get_to(row.run);
  json.at("attempt").get_to(row.attempt);
  json.at("label").get_to(row.label);
  json.at("ending").get_to(row.ending);
  json.at("reason").get_to(row.reason);
  json.at("demanded").get_to(row.demanded);
  json.at("achieved").get_to(row.achieved);
  json.at("rule").get_to(row.rule);
  row.at_least = json.value("at_least", 0.0);
  if (json.contains("reached")) row.reached = json["reached"].get<double>();
  return row;
} catch (const Json::exception& problem) {
  throw Error(Error::Kind::bad_file, say("a row of the journal cannot be read: {}", problem.what()));
}

std::optional<JournalRow> step_of(const RunRow& row, double time) {
  const bool begins = row.kind == RunRow::Kind::segment_begins;
  if (!begins && row.kind != RunRow::Kind::segment_ends) return std::nullopt;
  JournalRow step;
  step.time = time;
  step.segment = row.label;
  step.index = row.segment;
  step.run = row.run;
  step.attempt = row.attempt;
  step.step = begins ? JournalRow::Step::begins : JournalRow::Step::ends;
  step.finished = row.ending == "complete";
  step.reason = row.reason;
  return step;
}

JournalRow step_of(const RecordSwitch& record, double time) {
  JournalRow step;
  step.time = time;
  step.segment = record.label;
  step.index = record.segment;
  step.run = record.run;
  step.attempt = record.attempt;
  step.step = record.on ? JournalRow::Step::records : JournalRow::Step::pauses;
  return step;
}

std::string words_of(const RecordSwitch& record, std::size_t segments) {
  return fmt::format("segment {} of {} '{}'{}", record.segment + 1, segments, record.label,
                     record.attempt > 1 ? fmt::format(", attempt {}", record.attempt) : "");
}

}  // namespace tumble::conduct
