#include "tumble/recorder/run_row.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using RowJson = nlohmann::json;

constexpr std::array phase_names{"idle",      "preparing", "ready",     "moving",   "settling", "dwelling",
                                 "recording", "between",   "finishing", "complete", "holding",  "pausing",
                                 "paused",    "stopping",  "aborting",  "safe",     "faulted"};
constexpr std::array ending_names{"complete", "aborted", "stopped", "failed", "error", "faulted"};
constexpr std::array<std::string_view, 9> row_ending_names{"",      "complete", "aborted", "stopped", "failed",
                                                           "error", "faulted",  "held",    "paused"};
constexpr std::array<std::string_view, 28> event_names{
    "accepted",  "answer", "attempt", "clock",     "desk",   "end",     "estimate", "flood",   "guard",   "hold",
    "interlock", "late",   "link",    "link lost", "notice", "phase",   "prompt",   "records", "refused", "reply",
    "safe",      "settle", "skip",    "stopped",   "stream", "timeout", "unit",     "other"};

RunRow::Ending row_ending(const std::string& word) {
  const auto found = std::ranges::find(row_ending_names, word);
  if (found == row_ending_names.end())
    throw Error(Error::Kind::bad_file, say("a row of the journal has an unknown ending '{}'", Name{word}));
  return static_cast<RunRow::Ending>(found - row_ending_names.begin());
}

}  // namespace

std::string_view name(RunPhase phase) { return phase_names.at(static_cast<std::size_t>(phase)); }

std::string_view name(RunEnding ending) { return ending_names.at(static_cast<std::size_t>(ending)); }

Sentence said_ending(RunEnding ending, const Sentence& text) {
  const char* const word = ending_names.at(static_cast<std::size_t>(ending));
  return text.empty() ? Sentence(word) : say("{}: {}", word, text);
}

std::string_view name(EventKind kind) { return event_names.at(static_cast<std::size_t>(kind)); }

std::string_view name(RunRow::Ending ending) { return row_ending_names.at(static_cast<std::size_t>(ending)); }

EventKind event_kind(std::string_view word) {
  const auto found = std::ranges::find(event_names, word);
  return found == event_names.end() ? EventKind::other : static_cast<EventKind>(found - event_names.begin());
}

RunRow::Ending row_ending(RunEnding ending) {
  static_assert(static_cast<int>(RunRow::Ending::faulted) == static_cast<int>(RunEnding::faulted) + 1);
  return static_cast<RunRow::Ending>(static_cast<int>(ending) + 1);
}

std::map<std::size_t, int> counted_attempts(const std::vector<RunRow>& journal) {
  std::map<std::size_t, int> attempts;
  std::map<std::size_t, int> runs;
  for (const auto& row : journal) {
    if (row.kind == RunRow::Kind::power_up)
      std::erase_if(attempts, [&](const auto& entry) { return runs.at(entry.first) == row.run; });
    if (row.kind != RunRow::Kind::segment_ends || row.ending != RunRow::Ending::complete) continue;
    attempts[row.segment] = row.attempt;
    runs[row.segment] = row.run;
  }
  return attempts;
}

std::string text_of(const RunRow& row) {
  RowJson json{{"kind", static_cast<int>(row.kind)},
               {"time", row.time},
               {"segment", row.segment},
               {"run", row.run},
               {"attempt", row.attempt},
               {"label", row.label},
               {"ending", name(row.ending)},
               {"reason", row.reason.text()},
               {"demanded", row.demanded},
               {"achieved", row.achieved},
               {"rule", row.rule},
               {"at_least", row.at_least}};
  if (row.reached) json["reached"] = *row.reached;
  if (const auto said = sentence_to_json(row.reason); !said.empty()) json["reason_said"] = RowJson::parse(said);
  return json_text(json);
}

RunRow row_of(const std::string& text) try {
  const RowJson json = RowJson::parse(text);
  RunRow row;
  const int kind = json.at("kind");
  if (kind < 0 || kind > static_cast<int>(RunRow::Kind::pauses))
    throw Error(Error::Kind::bad_file, "a row of the journal has an unknown kind");
  row.kind = static_cast<RunRow::Kind>(kind);
  json.at("time").get_to(row.time);
  json.at("segment").get_to(row.segment);
  json.at("run").get_to(row.run);
  json.at("attempt").get_to(row.attempt);
  json.at("label").get_to(row.label);
  row.ending = row_ending(json.at("ending").get<std::string>());
  const std::string reason = json.at("reason");  // of version 1: all that is known
  row.reason = json.contains("reason_said") ? sentence_from_json(json_text(json["reason_said"])) : Sentence(reason);
  json.at("demanded").get_to(row.demanded);
  json.at("achieved").get_to(row.achieved);
  json.at("rule").get_to(row.rule);
  row.at_least = json.value("at_least", 0.0);
  if (json.contains("reached")) row.reached = json["reached"].get<double>();
  return row;
} catch (const RowJson::exception& problem) {
  throw Error(Error::Kind::bad_file, say("a row of the journal cannot be read: {}", problem.what()));
}

}  // namespace tumble
