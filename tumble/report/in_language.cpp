#include "tumble/report/in_language.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>

#include "tumble/language/said.hpp"
#include "tumble/language/texts.hpp"
#include "tumble/report/names.hpp"

namespace tumble {
namespace {

void say_in(Language language, std::string& text) {
  if (auto said = result_words_in(language, text)) text = std::move(*said);
}

/// A name may mean something else in one method, or in one table: "allan_noise terms term", "models rate".
std::string column_in(Language language, const std::string& method, const Table& table, const std::string& name) {
  if (auto text = find_text(language, "result", table.name + " " + name)) return *text;
  return readable_name(language, name, method + " " + table.name);
}

void say_table_in(Language language, const std::string& method, Table& table) {
  say_in(language, table.caption);
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const bool names = has_names(table.columns[i].name);
    table.columns[i].name = column_in(language, method, table, table.columns[i].name);
    for (auto& row : table.rows)
      if (auto* text = std::get_if<std::string>(&row[i]); text && !names) say_in(language, *text);
  }
}

/// The recordings as a title names them that the program made, "day 1.csv and 2 more"; absent: it made another title,
/// or a user did. The file of a calibration may stand before the recordings.
std::optional<std::string> recordings_in_title(const Estimate& estimate) {
  const auto& inputs = estimate.provenance.inputs;
  for (std::size_t first = 0; first < std::min(inputs.size(), std::size_t{2}); ++first) {
    const std::size_t count = inputs.size() - first;
    const auto name = std::filesystem::path(inputs[first].file).filename().string();
    for (const auto& files : {count == 1 ? name : fmt::format("{} and {} more", name, count - 1),
                              fmt::format("{} files, one record", count)})
      if (estimate.title == estimate.method + " of " + files) return files;
  }
  return std::nullopt;
}

/// That of a plan which travels with the program, or one that the program made of the method; titles of users stay.
std::string title_in(Language language, const Estimate& estimate) {
  const auto name = result_words_in(language, estimate.method).value_or(estimate.method);
  if (estimate.title == estimate.method) return name;
  const auto files = recordings_in_title(estimate);
  return files ? name + "：" + result_words_in(language, *files).value_or(*files) : said_in(language, estimate.title);
}

void say_axis_in(Language language, Figure::Axis& axis) { axis.name = readable_name(language, axis.name); }

}  // namespace

bool has_names(const std::string& column) {
  static const std::array<std::string_view, 17> names{
      "segment", "segments", "label",   "channel",  "file", "recording",      "parameter", "unit", "unit_name",
      "symbol",  "key",      "section", "position", "row",  "departure_name", "target",    "said"};
  return std::ranges::find(names, column) != names.end();
}

Estimate in_language(Language language, Estimate estimate) {
  if (language == Language::english) return estimate;
  estimate.title = title_in(language, estimate);
  for (auto& parameter : estimate.parameters)
    if (auto text = find_text(language, "result", estimate.method + " " + parameter.description))
      parameter.description = *text;
    else
      say_in(language, parameter.description);
  for (auto& part : estimate.budget) say_in(language, part.source);
  for (auto& table : estimate.tables) say_table_in(language, estimate.method, table);
  if (estimate.prior && estimate.prior->with_prior) {
    PriorUse use = *estimate.prior;
    use.with_prior = std::make_shared<Estimate>(in_language(language, *use.with_prior));
    estimate.prior = std::make_shared<PriorUse>(std::move(use));
  }
  return estimate;
}

Figure in_language(Language language, Figure figure) {
  if (language == Language::english) return figure;
  figure.language = language;
  figure.name = readable_name(language, figure.name);
  say_axis_in(language, figure.x), say_axis_in(language, figure.y);
  if (figure.z) say_axis_in(language, *figure.z);
  for (auto& series : figure.series) {
    series.name = readable_name(language, series.name);
    say_in(language, series.band);
  }
  for (auto& note : figure.notes) say_in(language, note);
  return figure;
}

std::vector<Figure> in_language(Language language, std::vector<Figure> figures) {
  for (auto& figure : figures) figure = in_language(language, std::move(figure));
  return figures;
}

}  // namespace tumble
