#include "archive_views.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tumble/report/text_table.hpp"

namespace tumble::cli {
namespace {

using Json = nlohmann::ordered_json;
using Align = TextColumn::Align;

constexpr std::size_t digits = 12;  // of a SHA-256 for people
constexpr std::size_t most_problems = 50;

TextColumn left(std::string name) { return {std::move(name), "", {}, Align::left}; }

/// Heading and table; nothing where it has no rows.
std::string titled(const std::string& title, const std::vector<TextColumn>& columns, std::size_t width) {
  return columns.front().cells.empty() ? "" : "\n" + title + "\n" + text_table(columns, width);
}

std::string written(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

std::string results_table(const UnitRecord& record, std::size_t width) {
  TextColumn when = left("test ended"), method = left("method"), verdict = left("verdict"), who = left("by"),
             id = left("result"), note = left("");
  for (const auto& result : record.results) {
    when.cells.push_back(result.ended.empty() ? result.archived + " (archived)" : result.ended);
    method.cells.push_back(result.method);
    verdict.cells.push_back(result.verdict);
    who.cells.push_back(result.who);
    id.cells.push_back(result.sha256.substr(0, digits));
    std::string words = result.simulated ? "simulated" : "";
    if (!result.correction.empty())
      words += fmt::format("{}replaced by {}: {}", words.empty() ? "" : "; ", result.replaced_by.substr(0, digits),
                           result.correction);
    note.cells.push_back(words);
  }
  return titled("Results", {when, method, verdict, who, id, note}, width);
}

std::string files_table(const UnitRecord& record, std::size_t width) {
  TextColumn role = left("file"), name = left("name"), id = left("SHA-256"), bytes{"bytes", "", {}};
  for (const auto& file : record.files) {
    role.cells.push_back(file.role);
    name.cells.push_back(file.name);
    bytes.cells.push_back(fmt::format("{}", file.bytes));
    id.cells.push_back(file.sha256.substr(0, digits));
  }
  return titled("Files", {role, name, bytes, id}, width);
}

std::string runs_table(const UnitRecord& record, std::size_t width) {
  TextColumn started = left("started"), title = left("title"), station = left("station"), who = left("operator"),
             ending = left("ended"), slot = left("slot"), id = left("run");
  for (const auto& run : record.runs) {
    started.cells.push_back(run.started);
    title.cells.push_back(run.title);
    station.cells.push_back(run.station);
    slot.cells.push_back(run.slot);
    who.cells.push_back(run.who);
    ending.cells.push_back(run.ending);
    id.cells.push_back(run.id.substr(0, digits));
  }
  return titled("Runs", {started, title, station, slot, who, ending, id}, width);
}

std::string certificates_table(const UnitRecord& record, std::size_t width) {
  TextColumn number = left("certificate"), format = left("format"), issued = left("issued"), who = left("by"),
             result = left("result");
  for (const auto& one : record.certificates) {
    number.cells.push_back(one.number);
    format.cells.push_back(one.format);
    issued.cells.push_back(one.issued);
    who.cells.push_back(one.issued_by);
    result.cells.push_back(one.result.substr(0, digits));
  }
  return titled("Certificates", {number, format, issued, who, result}, width);
}

std::string signatures_table(const UnitRecord& record, std::size_t width) {
  TextColumn meaning = left("signature"), kind = left("of"), id = left("SHA-256"), when = left("time"),
             who = left("by"), reason = left("why"), note = left("");
  for (const auto& one : record.signatures) {
    meaning.cells.push_back(one.meaning);
    kind.cells.push_back(one.kind);
    id.cells.push_back(one.sha256.substr(0, digits));
    when.cells.push_back(one.when);
    who.cells.push_back(one.who);
    reason.cells.push_back(one.why);
    note.cells.push_back(one.problem.empty() ? "" : "does not hold: " + one.problem);
  }
  return titled("Signatures", {meaning, kind, id, when, who, reason, note}, width);
}

std::string steps_table(const std::vector<ArchivedStep>& steps, std::size_t longest, std::size_t width) {
  TextColumn number{"", "", {}}, when = left("time"), who = left("by"), action = left("what"), subject = left("which"),
                                 reason = left("why");
  for (const auto& step : steps) {
    number.cells.push_back(fmt::format("{}", step.number));
    when.cells.push_back(step.when);
    who.cells.push_back(step.who);
    action.cells.push_back(step.action);
    subject.cells.push_back(step.subject.substr(0, longest));
    reason.cells.push_back(step.reason);
  }
  return titled("Events", {number, when, who, action, subject, reason}, width);
}

}  // namespace

std::string units_text(const std::vector<ArchivedUnit>& units, std::size_t width) {
  TextColumn model = left("model"), serial = left("serial"), first = left("first"), last = left("last"),
             count{"results", "", {}};
  for (const auto& unit : units) {
    model.cells.push_back(unit.name.model);
    serial.cells.push_back(unit.name.serial);
    count.cells.push_back(fmt::format("{}", unit.results));
    first.cells.push_back(unit.first);
    last.cells.push_back(unit.last);
  }
  return units.empty() ? "the archive has no units\n" : text_table({model, serial, count, first, last}, width);
}

std::string record_text(const UnitRecord& record, std::size_t width) {
  return fmt::format("{}/{}\n", record.name.model, record.name.serial) + results_table(record, width) +
         runs_table(record, width) + files_table(record, width) + certificates_table(record, width) +
         signatures_table(record, width) + steps_table(record.steps, digits, width);
}

std::string run_text(const RunRecord& record, std::size_t width) {
  constexpr std::size_t longest = 80;
  const auto& run = record.run;
  std::string text = fmt::format("{}\nrun {} at {}, by {}, {}\n", run.title, run.id, run.station, run.who, run.ending);
  if (!run.started.empty()) text += fmt::format("from {} to {}\n", run.started, run.ended);
  for (const auto& [slot, unit] : record.units) text += fmt::format("slot {}: {}/{}\n", slot, unit.model, unit.serial);
  for (const auto& [name, certificate] : record.equipment)
    text += fmt::format("equipment {}{}\n", name, certificate.empty() ? "" : ", certificate " + certificate);
  return text + steps_table(record.steps, longest, width);
}

std::string due_text(const std::vector<DueCalibration>& due, const std::vector<DueUnit>& units,
                     const std::string& today, std::size_t width) {
  struct Line {
    std::string day, what, last;
  };
  std::vector<Line> lines;
  for (const auto& one : due) lines.push_back({one.due, one.equipment, one.certificate});
  for (const auto& one : units) lines.push_back({one.due, one.unit.model + "/" + one.unit.serial, one.last});
  if (lines.empty()) return "nothing is due by then\n";
  std::ranges::stable_sort(lines, {}, &Line::day);
  TextColumn day = left("due"), what = left("what"), last = left("since"), note = left("");
  for (const auto& line : lines) {
    day.cells.push_back(line.day);
    what.cells.push_back(line.what);
    last.cells.push_back(line.last);
    note.cells.emplace_back(line.day < today ? "has ended" : "");
  }
  return text_table({day, what, last, note}, width);
}

std::string recomputation_text(const Recomputation& again) {
  if (again.same_bytes) return fmt::format("the same to the last byte: {}\n", again.archived_sha256);
  if (again.same) return fmt::format("the same, except for the folders of its files: {}\n", again.archived_sha256);
  std::string text = fmt::format("archived {}, by version {}\nnow      {}, by version {}\n", again.archived_sha256,
                                 again.archived_program, again.new_sha256, again.new_program);
  if (again.differing.empty()) return text + "only the version differs; all values are the same\n";
  text += fmt::format("these parts differ: {}\n", fmt::join(again.differing, ", "));
  if (!again.parameter.empty())
    text += fmt::format("values: most {}, by {:.2g} of its standard uncertainty\n", again.parameter, again.difference);
  return text +
         "a result does not depend on the number of threads: another version, compiler or processor explains it\n";
}

std::string recomputation_json(const Recomputation& again) {
  Json json{{"same", again.same},
            {"same_bytes", again.same_bytes},
            {"archived", {{"sha256", again.archived_sha256}, {"tumble", again.archived_program}}},
            {"now", {{"sha256", again.new_sha256}, {"tumble", again.new_program}}},
            {"differing", again.differing},
            {"parameter", again.parameter}};
  json["difference"] = std::isfinite(again.difference) ? Json(again.difference) : Json(nullptr);
  return written(json);
}

std::string check_text(const ArchiveCheck& check) {
  std::string text = fmt::format("looked at: chains {}, events {}, results {}, files {}\n", check.chains, check.events,
                                 check.results, check.files);
  if (check.problems.empty()) return text + fmt::format("nothing has changed\nheads of the chains: {}\n", check.heads);
  text += fmt::format("changed: {}\n", check.problems.size());
  for (std::size_t i = 0; i < std::min(most_problems, check.problems.size()); ++i)
    text += "  " + check.problems[i] + "\n";
  if (check.problems.size() > most_problems)
    text += fmt::format("  and {} more\n", check.problems.size() - most_problems);
  return text;
}

}  // namespace tumble::cli
