#include "tumble/report/report.hpp"

#include <fmt/format.h>

#include <memory>

#include "tumble/report/figure.hpp"
#include "tumble/report/image.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct ReportArguments {
  std::string result, page, figure, title, logo, language;
};

/// That of the page, else that of the terminal.
Language language_of(const ReportArguments& arguments, const Terminal& terminal) {
  if (arguments.language.empty()) return terminal.language;
  return arguments.language == "zh" ? Language::chinese : Language::english;
}

void write_figures_of(const Estimate& estimate, const ReportArguments& arguments, const Terminal& terminal) {
  const auto figures = figures_of(estimate);
  if (figures.empty())
    throw Error(Error::Kind::unsupported,
                say("{}: a result of {} has no figure", Name{arguments.result}, Name{estimate.method}));
  write_figures(figures, arguments.figure, language_of(arguments, terminal), terminal);
}

PageOptions page_of(const ReportArguments& arguments, const Terminal& terminal) {
  return {arguments.title, arguments.logo.empty() ? "" : data_uri_of_image_file(arguments.logo),
          language_of(arguments, terminal)};
}

int run(const ReportArguments& arguments, const Terminal& terminal) {
  if (arguments.page.empty() && arguments.figure.empty())
    throw Error(Error::Kind::bad_input, "report: -o REPORT.html or --figure FIGURE.svg is required");
  if (!arguments.page.empty()) check_output("-o", arguments.page, {arguments.result}, {".html", ".htm"});
  if (!arguments.figure.empty()) check_output("--figure", arguments.figure, {arguments.result}, {".svg"});
  const auto estimate = read_result(arguments.result);
  if (!arguments.page.empty()) {
    write_output(terminal, arguments.page, to_html(estimate, page_of(arguments, terminal)));
  }
  if (!arguments.figure.empty()) write_figures_of(estimate, arguments, terminal);
  return 0;
}

}  // namespace

Verb report_verb() {
  auto arguments = std::make_shared<ReportArguments>();
  return {"report",
          "Write a result as one HTML page that needs no network, or its figures as drawings",
          {{"RESULT", &arguments->result, "result (.json) of identify or predict; - reads standard input", true},
           {"-o,--output", &arguments->page, "page to write (.html); - writes to standard output"},
           {"--title", &arguments->title, "title of the page (default: that of the plan)"},
           {"--logo", &arguments->logo, "picture at the top of the page (.png, .jpg, .svg)"},
           {"--language", &arguments->language, "of the page and of figures (default: that of the program)", false, "",
            language_codes()},
           {"--figure", &arguments->figure,
            "drawing to write (.svg); a result of several figures gives FIGURE-1.svg, FIGURE-2.svg, ..."}},
          "Examples:\n  tumble report fog.json -o fog.html\n  tumble report noise.json --figure noise.svg\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
