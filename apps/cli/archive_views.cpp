#include "archive_views.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/language/said.hpp"
#include "tumble/language/section_words.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::cli {
namespace {

using Json = nlohmann::ordered_json;
using Align = TextColumn::Align;

constexpr std::size_t digits = 12;  // of a SHA-256 for people
constexpr std::size_t most_problems = 50;

/// The texts of the views and the width of their tables.
struct View {
  std::size_t width;
  SectionWords words;

  explicit View(const Terminal& terminal) : width(terminal.width), words{terminal.language, "archive"} {}
  TextColumn left(const char* key) const { return {words(key), "", {}, Align::left}; }
  TextColumn right(const char* key) const { return {words(key), "", {}}; }
};

TextColumn blank() { return {"", "", {}, Align::left}; }

/// Heading and table; nothing where it has no rows.
std::string titled(const char* title, const std::vector<TextColumn>& columns, const View& view) {
  return columns.front().cells.empty() ? "" : "\n" + view.words(title) + "\n" + text_table(columns, view.width);
}

std::string written(const Json& json) { return json_text(json, 1) + "\n"; }

std::string results_table(const UnitRecord& record, const View& view) {
  TextColumn when = view.left("test_ended"), method = view.left("method"), verdict = view.left("verdict"),
             who = view.left("by"), id = view.left("result"), note = blank();
  for (const auto& result : record.results) {
    when.cells.push_back(result.ended.empty() ? view.words.with("archived_at", result.archived) : result.ended);
    method.cells.push_back(result.method);
    verdict.cells.push_back(result.verdict);
    who.cells.push_back(result.who);
    id.cells.push_back(first_digits(result.sha256, digits));
    std::string words = result.simulated ? view.words("simulated") : "";
    if (!result.correction.empty())
      words += (words.empty() ? "" : view.words("semicolon")) +
               view.words.with("replaced_by", first_digits(result.replaced_by, digits), result.correction);
    note.cells.push_back(words);
  }
  return titled("results", {when, method, verdict, who, id, note}, view);
}

std::string files_table(const UnitRecord& record, const View& view) {
  TextColumn role = view.left("file"), name = view.left("name"), id{"SHA-256", "", {}, Align::left},
             bytes = view.right("bytes");
  for (const auto& file : record.files) {
    role.cells.push_back(file.role);
    name.cells.push_back(file.name);
    bytes.cells.push_back(fmt::format("{}", file.bytes));
    id.cells.push_back(first_digits(file.sha256, digits));
  }
  return titled("files", {role, name, bytes, id}, view);
}

std::string runs_table(const UnitRecord& record, const View& view) {
  TextColumn started = view.left("started"), title = view.left("title"), station = view.left("station"),
             who = view.left("operator"), ending = view.left("ended"), slot = view.left("slot"), id = view.left("run");
  for (const auto& run : record.runs) {
    started.cells.push_back(run.started);
    title.cells.push_back(run.title);
    station.cells.push_back(run.station);
    slot.cells.push_back(run.slot);
    who.cells.push_back(run.who);
    ending.cells.push_back(run.ending);
    id.cells.push_back(first_digits(run.id, digits));
  }
  return titled("runs", {started, title, station, slot, who, ending, id}, view);
}

std::string certificates_table(const UnitRecord& record, const View& view) {
  TextColumn number = view.left("certificate"), format = view.left("format"), issued = view.left("issued"),
             who = view.left("by"), result = view.left("result");
  for (const auto& one : record.certificates) {
    number.cells.push_back(one.number);
    format.cells.push_back(one.format);
    issued.cells.push_back(one.issued);
    who.cells.push_back(one.issued_by);
    result.cells.push_back(first_digits(one.result, digits));
  }
  return titled("certificates", {number, format, issued, who, result}, view);
}

std::string signatures_table(const UnitRecord& record, const View& view) {
  TextColumn meaning = view.left("signature"), kind = view.left("of"), id{"SHA-256", "", {}, Align::left};
  TextColumn when = view.left("time"), who = view.left("by"), reason = view.left("why"), note = blank();
  for (const auto& one : record.signatures) {
    meaning.cells.push_back(one.meaning);
    kind.cells.push_back(one.kind);
    id.cells.push_back(first_digits(one.sha256, digits));
    when.cells.push_back(one.when);
    who.cells.push_back(one.who);
    reason.cells.push_back(one.why);
    note.cells.push_back(one.problem.empty() ? "" : view.words.with("does_not_hold", one.problem));
  }
  return titled("signatures", {meaning, kind, id, when, who, reason, note}, view);
}

std::string steps_table(const std::vector<ArchivedStep>& steps, std::size_t longest, const View& view) {
  TextColumn number{"", "", {}}, when = view.left("time"), who = view.left("by"), action = view.left("what"),
                                 subject = view.left("which"), reason = view.left("why");
  for (const auto& step : steps) {
    number.cells.push_back(fmt::format("{}", step.number));
    when.cells.push_back(step.when);
    who.cells.push_back(step.who);
    action.cells.push_back(step.action);
    subject.cells.push_back(first_digits(step.subject, longest));
    reason.cells.push_back(step.reason);
  }
  return titled("events", {number, when, who, action, subject, reason}, view);
}

}  // namespace

std::string units_text(const std::vector<ArchivedUnit>& units, const Terminal& terminal) {
  const View view(terminal);
  TextColumn model = view.left("model"), serial = view.left("serial"), first = view.left("first"),
             last = view.left("last"), count = view.right("count_of_results");
  for (const auto& unit : units) {
    model.cells.push_back(unit.name.model);
    serial.cells.push_back(unit.name.serial);
    count.cells.push_back(fmt::format("{}", unit.results));
    first.cells.push_back(unit.first);
    last.cells.push_back(unit.last);
  }
  if (units.empty()) return view.words("no_units") + "\n";
  return text_table({model, serial, count, first, last}, view.width);
}

std::string record_text(const UnitRecord& record, const Terminal& terminal) {
  const View view(terminal);
  return fmt::format("{}/{}\n", record.name.model, record.name.serial) + results_table(record, view) +
         runs_table(record, view) + files_table(record, view) + certificates_table(record, view) +
         signatures_table(record, view) + steps_table(record.steps, digits, view);
}

std::string run_text(const RunRecord& record, const Terminal& terminal) {
  constexpr std::size_t longest = 80;
  const View view(terminal);
  const auto& words = view.words;
  const auto& run = record.run;
  std::string text = run.title + "\n" + words.with("run_is", run.id, run.station, run.who, run.ending) + "\n";
  if (!run.started.empty()) text += words.with("from_to", run.started, run.ended) + "\n";
  for (const auto& [slot, unit] : record.units) text += words.with("slot_is", slot, unit.model, unit.serial) + "\n";
  for (const auto& [name, certificate] : record.equipment)
    text += words.with("equipment_is", name) +
            (certificate.empty() ? "" : words.with("with_certificate", certificate)) + "\n";
  return text + steps_table(record.steps, longest, view);
}

std::string due_text(const std::vector<DueCalibration>& due, const std::vector<DueUnit>& units,
                     const std::string& today, const Terminal& terminal) {
  const View view(terminal);
  struct Line {
    std::string day, what, last;
  };
  std::vector<Line> lines;
  for (const auto& one : due) lines.push_back({one.due, one.equipment, one.certificate});
  for (const auto& one : units) lines.push_back({one.due, one.unit.model + "/" + one.unit.serial, one.last});
  if (lines.empty()) return view.words("nothing_due") + "\n";
  std::ranges::stable_sort(lines, {}, &Line::day);
  TextColumn day = view.left("due"), what = view.left("what"), last = view.left("since"), note = blank();
  for (const auto& line : lines) {
    day.cells.push_back(line.day);
    what.cells.push_back(line.what);
    last.cells.push_back(line.last);
    note.cells.emplace_back(line.day < today ? view.words("has_ended") : "");
  }
  return text_table({day, what, last, note}, view.width);
}

std::string recomputation_text(const Recomputation& again, const Terminal& terminal) {
  const auto words = View(terminal).words;
  if (again.same_bytes) return words.with("same_bytes", again.archived_sha256) + "\n";
  if (again.same) return words.with("same_except_folders", again.archived_sha256) + "\n";
  std::string text = words.with("archived_by", again.archived_sha256, again.archived_program) + "\n" +
                     words.with("now_by", again.new_sha256, again.new_program) + "\n";
  if (again.differing.empty()) return text + words("only_version_differs") + "\n";
  text += words.with("parts_differ", fmt::format("{}", fmt::join(again.differing, words("comma")))) + "\n";
  if (!again.parameter.empty())
    text += words.with("values_differ", again.parameter, fmt::format("{:.2g}", again.difference)) + "\n";
  return text + words("why_recomputation_differs") + "\n";
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

std::string check_text(const ArchiveCheck& check, const Terminal& terminal) {
  const auto words = View(terminal).words;
  std::string text = words.with("looked_at", check.chains, check.events, check.results, check.files) + "\n";
  if (!check.shared_numbers.empty()) text += words.with("shared_numbers", check.shared_numbers.size()) + "\n";
  for (const auto& one : check.shared_numbers) text += "  " + in_language(terminal.language, one) + "\n";
  if (check.problems.empty()) return text + words.with("nothing_changed", check.heads) + "\n";
  text += words.with("changed", check.problems.size()) + "\n";
  for (std::size_t i = 0; i < std::min(most_problems, check.problems.size()); ++i)
    text += "  " + in_language(terminal.language, check.problems[i]) + "\n";
  if (check.problems.size() > most_problems)
    text += "  " + words.with("and_more", check.problems.size() - most_problems) + "\n";
  return text;
}

}  // namespace tumble::cli
