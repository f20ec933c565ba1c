#include <fmt/format.h>

#include <cmath>
#include <map>

#include "tumble/archive/history.hpp"
#include "tumble/archive/statistics.hpp"
#include "tumble/core/message_in.hpp"
#include "tumble/language/said.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/in_language.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/archive.hpp"
#include "tumble/serve/routes/query.hpp"

namespace tumble::routes {
namespace {

/// A column as texts that line up at the decimal point, as reports have it.
std::vector<std::string> cells_of(const Table& table, std::size_t index) {
  std::vector<double> numbers;
  for (const auto& row : table.rows) {
    const auto* number = std::get_if<double>(&row[index]);
    numbers.push_back(number ? table.columns[index].unit.from_si(*number) : NAN);
  }
  auto cells = lined_up(numbers, "\u2007", "\u2008");
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    if (const auto* text = std::get_if<std::string>(&table.rows[i][index])) cells[i] = *text;
  return cells;
}

Json json_of(const Table& table, Language language) {
  Json json{{"name", table.name},
            {"title", result_words_in(language, table.name).value_or(table.name)},
            {"caption", table.caption},
            {"columns", Json::array()},
            {"cells", Json::array()}};
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    bool numbers = false;
    for (const auto& row : table.rows) numbers |= std::holds_alternative<double>(row[i]);
    const auto unit = table.columns[i].unit.text();
    json["columns"].push_back(
        {{"name", table.columns[i].name}, {"unit", unit == "1" ? "" : unit}, {"number", numbers}});
    json["cells"].push_back(cells_of(table, i));
  }
  return json;
}

/// Where the points of a series lead: "result" with its SHA-256, or "unit"; null for a point that leads nowhere.
struct Links {
  const Table* table;
  std::map<std::int64_t, std::string> results;

  Links(const Archive& archive, const Estimate& estimate) : table(find_table(estimate, "links")) {
    std::vector<std::int64_t> numbers;
    if (table == nullptr || table->rows.size() > most_links) return;
    for (const auto& row : table->rows)
      if (const auto& number = std::get<std::string>(row[4]); !number.empty()) numbers.push_back(std::stoll(number));
    results = sha256_by_number(archive, numbers);
  }

  /// Given: the axes of the figure, in whose units the points are.
  Json of(const Figure& figure, const Figure::Series& series) const {
    Json links = Json::array();
    if (table == nullptr || table->rows.size() > most_links || !series.points) return links;
    std::map<std::pair<double, double>, const std::vector<Table::Cell>*> row_at;
    for (const auto& row : table->rows)
      if (readable_name(std::get<std::string>(row[0])) == series.name)
        row_at[{figure.x.unit.from_si(std::get<double>(row[1])), figure.y.unit.from_si(std::get<double>(row[2]))}] =
            &row;
    if (row_at.empty()) return links;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      const auto found = row_at.find({series.x[i], series.y[i]});
      links.push_back(found == row_at.end() ? Json() : link_of(*found->second));
    }
    return links;
  }

  Json link_of(const std::vector<Table::Cell>& row) const {
    const auto& unit = std::get<std::string>(row[3]);
    const auto& number = std::get<std::string>(row[4]);
    if (number.empty()) return {{"unit", unit}, {"result", ""}};
    const auto found = results.find(std::stoll(number));
    return {{"unit", unit}, {"result", found == results.end() ? "" : found->second}};
  }

  static constexpr std::size_t most_links = 5000;
};

/// The figures as pages draw them, with their drawing, numbers and links.
Json figures_with_links(const Archive& archive, const Estimate& estimate, Language language) {
  const Links links(archive, estimate);
  const auto figures = figures_of(estimate);
  const auto shown = in_language(language, figures);
  Json described = Json::parse(to_json(shown));
  for (std::size_t i = 0; i < figures.size(); ++i) {
    described[i]["svg"] = to_svg(shown[i]);
    described[i]["csv"] = to_csv(figures[i]);
    for (std::size_t k = 0; k < figures[i].series.size(); ++k)
      if (auto of = links.of(figures[i], figures[i].series[k]); !of.empty()) described[i]["series"][k]["links"] = of;
  }
  return described;
}

Json json_of(const Archive& archive, const Estimate& original, Language language) {
  const Estimate estimate = in_language(language, original);
  Json json{{"title", estimate.title},
            {"parameters", Json::array()},
            {"tables", Json::array()},
            {"findings", Json::array()},
            {"figures", figures_with_links(archive, original, language)}};
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const auto& parameter = estimate.parameters[i];
    json["parameters"].push_back({{"name", result_words_in(language, parameter.name).value_or(parameter.name)},
                                  {"description", parameter.description},
                                  {"text", measured_text(estimate, parameter.name, language)},
                                  {"interval", interval_text(estimate, i)}});
  }
  for (const auto& table : estimate.tables)
    if (!table.for_programs) json["tables"].push_back(json_of(table, language));
  static const char* const severities[] = {"info", "warning", "error"};
  for (const auto& finding : estimate.findings)
    json["findings"].push_back({{"severity", severities[static_cast<std::size_t>(finding.severity)]},
                                {"message", message_in(language, finding)}});
  return json;
}

/// A limit such as "0.5 deg/h" [SI]; `absent` where none is given.
double limit_in(const HttpRequest& request, const char* which, const Unit& unit, double absent) {
  const auto text = optional(request, which);
  return text.empty() ? absent : parse_si(text, unit);
}

ParameterLimits limits_in(const HttpRequest& request, const Unit& unit) {
  ParameterLimits limits;
  limits.lower = limit_in(request, "min", unit, limits.lower);
  limits.upper = limit_in(request, "max", unit, limits.upper);
  if (!(limits.lower < limits.upper)) throw Error{Error::Kind::bad_input, "the lower limit is not below the upper one"};
  return limits;
}

/// Of a unit or of the units of a model.
ArchivedSelection selection_in(const Archive& archive, const HttpRequest& request) {
  ArchivedSelection what{required(request, "parameter")};
  if (const auto words = optional(request, "unit"); !words.empty()) {
    what.unit = find_unit(archive, words);
    what.model = what.unit.model;
  } else {
    what.model = required(request, "model");
  }
  return what;
}

/// Control charts, the drift of a unit, or the summary of a model: what `tumble archive` chart, history and summary
/// say.
HttpResponse chart(Context& context, const HttpRequest& request) {
  const Archive archive = archive_of(context);
  const auto what = selection_in(archive, request);
  const auto kind = required(request, "kind");
  const Language language = language_asked(request);
  if (kind == "chart")
    return json_response(
        json_of(archive, chart_of_archive(archive, {.what = what, .every_day = optional(request, "every_day") == "1"}),
                language));
  const Unit unit = parameter_over_units(archive, what.parameter, what.model, what.unit).shown;
  if (kind == "drift")
    return json_response(
        json_of(archive, drift_of_unit(archive, {.what = what, .limits = limits_in(request, unit)}), language));
  if (kind == "summary")
    return json_response(
        json_of(archive, summary_of_model(archive, {.what = what, .limits = limits_in(request, unit)}), language));
  throw Error{Error::Kind::bad_input, say("'kind' is chart, drift or summary, not '{}'", kind)};
}

}  // namespace

std::vector<Route> archive_chart_routes() { return {{"GET", "/api/archive/chart", chart}}; }

}  // namespace tumble::routes
