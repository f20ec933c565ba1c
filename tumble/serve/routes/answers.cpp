#include "tumble/serve/routes/answers.hpp"

#include "tumble/core/json_text.hpp"
#include "tumble/core/message_in.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/report/report.hpp"
#include "tumble/serve/routes/query.hpp"

namespace tumble::routes {

HttpResponse json_response(const Json& json, unsigned status) {
  HttpResponse response;
  response.status = status;
  response.body = json_text(json);
  return response;
}

namespace {

HttpResponse refusal_response(unsigned status, std::string_view code, const Problems& problems) {
  return json_response(
      {{"problems", texts_of(problems)}, {"errors", Json::parse(problems_to_json(code, problems, Language::english))}},
      status);
}

}  // namespace

HttpResponse problem_response(const Error& error) {
  unsigned status = 500;
  switch (error.kind) {
    case Error::Kind::bad_input:
      status = 400;
      break;
    case Error::Kind::unsupported:
      status = 404;
      break;
    case Error::Kind::bad_data:
    case Error::Kind::bad_file:
      status = 422;
      break;
    case Error::Kind::internal:
      break;
  }
  return refusal_response(status, code_of(error.kind), error.problems);
}

HttpResponse problem_response(unsigned status, const Problem& problem) {
  return problem_response(status, Problems{problem});
}

HttpResponse problem_response(unsigned status, const Problems& problems) {
  return refusal_response(status, status >= 500 ? "internal" : "refused", problems);
}

HttpResponse started(Context& context, const HttpRequest& request, Job job) {
  job.owner = user_of(context, request);
  return json_response({{"job", context.jobs.start(std::move(job))}}, 202);
}

Json findings_in(Language language, Json findings) {
  if (language == Language::english || !findings.is_array()) return findings;
  const Findings all = findings_from_json(findings.dump(), "findings");
  for (std::size_t i = 0; i < all.size(); ++i) findings[i]["message"] = message_in(language, all[i]);
  return findings;
}

}  // namespace tumble::routes
