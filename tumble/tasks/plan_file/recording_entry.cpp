#include "tumble/tasks/plan_file/recording_entry.hpp"

#include <algorithm>

#include "tumble/tasks/plan_file/file_named.hpp"
#include "tumble/tasks/sets.hpp"
#include "tumble/units/error.hpp"

namespace tumble::plan_file {

using tables::Section;

namespace {

char read_decimal(Section& section) {
  const auto text = section.text("decimal");
  if (!text) return '\0';
  try {
    return parse_decimal(*text);
  } catch (const Error& error) {
    section.problem_at("decimal", error.problems.front());
    return '\0';
  }
}

std::string read_date_order(Section& section) {
  const auto text = section.text("date");
  if (!text) return "";
  try {
    return parse_date_order(*text);
  } catch (const Error& error) {
    section.problem_at("date", error.problems.front());
    return "";
  }
}

}  // namespace

RecordingEntry read_recording_entry(Section& section, const std::filesystem::path& folder) {
  RecordingEntry entry;
  if (section.find("file") == nullptr) section.missing("file", "\"position-1.csv\"");
  entry.file = file_named(section, "file", folder).value_or(folder.string());
  entry.segment = section.text("segment").value_or("");
  entry.run = section.integer("run").value_or(0);
  entry.columns = section.texts("columns");
  entry.segment_column = section.text("segment_column").value_or("");
  entry.topics = section.texts("topics");
  entry.frames = section.text("frames").value_or("");
  if (entry.frames.find(".toml") != std::string::npos)
    entry.frames = file_named(section, "frames", folder).value_or("");
  entry.decimal = read_decimal(section);
  entry.time = section.text("time").value_or("");
  entry.date = read_date_order(section);
  entry.encoding = section.text("encoding").value_or("");
  entry.skip = static_cast<std::size_t>(std::max(section.integer("skip").value_or(0), 0));
  if (entry.run == 0 && section.find("run")) section.problem_at("run", "power-ups count from 1");
  return entry;
}

}  // namespace tumble::plan_file
