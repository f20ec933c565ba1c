// A route of one's own: the verdicts of a result, for a page that shows nothing else.

#include "tumble/report/limit_text.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"

namespace tumble::routes {
namespace {

const char* word_of(Verdict::Outcome outcome) {
  switch (outcome) {
    case Verdict::Outcome::pass:
      return "pass";
    case Verdict::Outcome::fail:
      return "fail";
    case Verdict::Outcome::undecided:
      break;
  }
  return "undecided";
}

/// {name, method, verdicts: [{parameter, value, limit, outcome}]}
HttpResponse verdicts(Context& context, const HttpRequest& request) {
  const std::string name = required(request, "file");
  const Language language = language_asked(request);
  const auto estimate = context.results.read(existing(context, name));
  Json verdicts = Json::array();
  for (const Verdict& verdict : estimate->verdicts)
    verdicts.push_back({{"parameter", verdict.parameter},
                        {"value", measured_text(*estimate, verdict.parameter, language)},
                        {"limit", limit_text(verdict.limit)},
                        {"outcome", word_of(verdict.outcome)}});
  return json_response({{"name", name}, {"method", estimate->method}, {"verdicts", verdicts}});
}

}  // namespace

std::vector<Route> my_routes() { return {{.method = "GET", .path = "/api/verdicts", .answer = verdicts}}; }

}  // namespace tumble::routes
