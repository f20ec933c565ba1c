#include <algorithm>
#include <filesystem>

#include "tumble/language/said.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/in_language.hpp"
#include "tumble/report/report.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/result_json.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/units/error.hpp"

namespace tumble::routes {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_results = 5000;
constexpr int deepest_result = 4;

Json entry_of(const std::string& name, const ResultSummary& summary, double modified, Language language) {
  return {{"name", name},
          {"method", summary.method},
          {"method_name", result_words_in(language, summary.method).value_or(summary.method)},
          {"title", said_in(language, summary.title)},
          {"model", summary.model},
          {"serial", summary.serial},
          {"date", summary.date},
          {"modified", modified},
          {"parameters", summary.parameters},
          {"passed", summary.passed},
          {"failed", summary.failed},
          {"undecided", summary.undecided},
          {"errors", summary.errors}};
}

/// The results of the folder and of its jobs, the newest first.
HttpResponse list_results(Context& context, const HttpRequest& request) {
  struct Found {
    double modified;
    std::string name;
    ResultSummary summary;
  };
  std::vector<Found> found;
  bool cut = false;
  std::error_code failed;
  fs::recursive_directory_iterator place(context.options.folder, fs::directory_options::skip_permission_denied, failed);
  for (; !failed && place != fs::recursive_directory_iterator(); place.increment(failed)) {
    const auto& path = place->path();
    const auto name = fs::relative(path, context.options.folder, failed).generic_string();
    if (is_hidden(path) || place.depth() + 1 >= deepest_result) place.disable_recursion_pending();
    if (path.extension() != ".json" || is_hidden(path) || place->is_symlink(failed) ||
        !place->is_regular_file(failed) || !is_plain_name(name))
      continue;
    const auto summary = context.results.summary(path.string());
    if (!summary) continue;
    cut = found.size() == most_results;
    if (cut) break;
    found.push_back({modified_of(path), name, *summary});
  }
  std::ranges::sort(found, [](const Found& a, const Found& b) {
    return a.modified != b.modified ? a.modified > b.modified : a.name < b.name;
  });
  Json results = Json::array();
  for (const auto& [modified, name, summary] : found)
    results.push_back(entry_of(name, summary, modified, language_asked(request)));
  return json_response({{"results", results}, {"cut", cut}});
}

std::shared_ptr<const Estimate> result_of(Context& context, const HttpRequest& request) {
  return context.results.read(existing(context, required(request, "file")));
}

HttpResponse one_result(Context& context, const HttpRequest& request) {
  Estimate estimate = *result_of(context, request);
  show_in_units(all_of(request, "unit"), estimate);
  Json answer{{"name", required(request, "file")}};
  answer.update(json_of_result(estimate, language_asked(request)));
  return json_response(answer);
}

HttpResponse result_figures(Context& context, const HttpRequest& request) {
  HttpResponse response;
  response.body = to_json(in_language(language_asked(request), figures_of(*result_of(context, request))));
  return response;
}

/// Figure number `figure` of the result, the first is 1.
Figure figure_asked(Context& context, const HttpRequest& request) {
  const auto figures = figures_of(*result_of(context, request));
  const double number = required_number(request, "figure");
  if (!(number >= 1.0 && number <= static_cast<double>(figures.size())))
    throw Error{Error::Kind::unsupported, say("the result has {} figures", figures.size())};
  return figures[static_cast<std::size_t>(number) - 1];
}

HttpResponse result_svg(Context& context, const HttpRequest& request) {
  HttpResponse response;
  response.type = "image/svg+xml";
  response.body = to_svg(in_language(language_asked(request), figure_asked(context, request)));
  return response;
}

HttpResponse result_csv(Context& context, const HttpRequest& request) {
  HttpResponse response;
  response.type = "text/csv; charset=utf-8";
  response.headers.emplace_back("Content-Disposition", "attachment; filename=\"figure.csv\"");
  response.body = to_csv(figure_asked(context, request));
  return response;
}

/// Covariance or correlation, in the units that are asked.
HttpResponse result_matrix(Context& context, const HttpRequest& request) {
  const auto kind = required(request, "kind");
  if (kind != "covariance" && kind != "correlation")
    throw Error{Error::Kind::bad_input, say("'kind' is covariance or correlation, not '{}'", kind)};
  Estimate estimate = *result_of(context, request);
  show_in_units(all_of(request, "unit"), estimate);
  HttpResponse response;
  response.type = "text/csv; charset=utf-8";
  response.headers.emplace_back("Content-Disposition", "attachment; filename=\"" + kind + ".csv\"");
  response.body = matrix_csv(estimate, kind == "correlation");
  return response;
}

/// The report, in a sandbox: it cannot ask the server as the user can.
HttpResponse result_page(Context& context, const HttpRequest& request) {
  HttpResponse response;
  response.type = "text/html; charset=utf-8";
  response.headers.emplace_back("Content-Security-Policy",
                                "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:");
  response.body = to_html(*result_of(context, request), {.language = language_asked(request)});
  return response;
}

HttpResponse result_file(Context& context, const HttpRequest& request) {
  HttpResponse response;
  response.headers.emplace_back("Content-Disposition", "attachment; filename=\"result.json\"");
  response.body = to_json(*result_of(context, request));
  return response;
}

constexpr std::size_t most_compared = 200;

HttpResponse compare_results(Context& context, const HttpRequest& request) {
  const auto names = all_of(request, "file");
  if (names.size() < 2 || names.size() > most_compared)
    throw Error{Error::Kind::bad_input, say("2 to {} results can be compared", most_compared)};
  std::vector<NamedResult> results;
  for (const auto& name : names) results.push_back({name, *context.results.read(existing(context, name))});
  return json_response(json_of_comparison(std::move(results), language_asked(request)));
}

}  // namespace

std::vector<Route> result_routes() {
  return {{"GET", "/api/results", list_results},           {"GET", "/api/result", one_result},
          {"GET", "/api/result/figures", result_figures},  {"GET", "/api/result/figure.svg", result_svg},
          {"GET", "/api/result/figure.csv", result_csv},   {"GET", "/api/result/matrix.csv", result_matrix},
          {"GET", "/api/result/page", result_page},        {"GET", "/api/result/file", result_file},
          {"GET", "/api/results/compare", compare_results}};
}

}  // namespace tumble::routes
