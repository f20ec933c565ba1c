#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "tumble/formats/format.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/archive.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/units/error.hpp"

namespace tumble::routes {

namespace fs = std::filesystem;

namespace {

/// A member of the body; `fallback` where it is absent. Throws Error::bad_input where it is of another kind.
template <class Value>
Value member(const Json& body, const char* name, Value fallback) {
  if (!body.contains(name)) return fallback;
  try {
    return body.at(name).get<Value>();
  } catch (const Json::exception&) {
    throw Error{Error::Kind::bad_input, say("'{}' is not of the kind that is expected", name)};
  }
}

std::string language_of(const Json& body) {
  const auto language = member<std::string>(body, "language", "en");
  return language == "zh" ? "zh" : "en";
}

void add_sets(const Sets& sets, Job::Step& step) {
  for (const auto& [key, value] : sets) step.push_back("--set=" + key + "=" + value);
}

std::string number_argument(double value) { return fmt::format("{}", value); }

/// A plan of the folder, or a method that needs none.
std::string what_to_identify(const Context& context, const Json& body) {
  const auto plan = member<std::string>(body, "plan", ""), method = member<std::string>(body, "method", "");
  if (plan.empty() == method.empty()) throw Error{Error::Kind::bad_input, "either a plan or a method is expected"};
  if (!plan.empty()) return existing(context, plan);
  if (find_method(method).needs_plan)
    throw Error{Error::Kind::bad_input, say("the method {} needs a plan", Name{method})};
  return method;
}

HttpResponse identify(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto names = member<std::vector<std::string>>(body, "recordings", {});
  Job job;
  job.kind = "identify";
  Job::Step step{"identify", what_to_identify(context, body)};
  for (const auto& name : names) step.push_back(existing(context, name));
  if (names.empty()) throw Error{Error::Kind::bad_input, "'recordings' names none"};
  step.insert(step.end(), {"--quiet", "-o", "{folder}/result.json"});
  if (!context.options.archive.empty()) step.push_back("--by=" + person_of(context, request));
  add_sets(sets_of(member<std::vector<std::string>>(body, "set", {})), step);
  job.title = fmt::format("{}: {}", fs::path(step[1]).filename().string(), names.front());
  job.steps = {step, {"report", "{folder}/result.json", "-o", "{folder}/report.html", "--language", language_of(body)}};
  return started(context, request, std::move(job));
}

/// Spectrum and Allan deviation of a span.
HttpResponse noise(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto file = member<std::string>(body, "file", "");
  const auto path = existing(context, file);
  const auto channels = member<std::vector<std::string>>(body, "channels", {});
  const double from = member<double>(body, "from", 0.0), to = member<double>(body, "to", 0.0);
  if (!(to > from)) throw Error{Error::Kind::bad_input, "the span ends before it begins"};
  if (channels.empty()) throw Error{Error::Kind::bad_input, "'channels' names none"};
  const Sets sets = sets_of(member<std::vector<std::string>>(body, "set", {}));
  Job::Step cut{"convert",
                path,
                "-o",
                "{folder}/span.h5",
                "--quiet",
                "--from=" + number_argument(from),
                "--to=" + number_argument(to)};
  for (const auto& channel : channels) cut.push_back("--channel=" + channel);
  add_sets(sets, cut);
  Job::Step step{"identify", "allan_noise",          "{folder}/span.h5",    "--quiet",
                 "-o",       "{folder}/result.json", "--set=spectrum=welch"};
  if (channels.size() == 1) step.push_back("--set=channels.signal=" + channels.front());
  Job job;
  job.kind = "noise";
  job.title = fmt::format("{}: {:.6g} s ... {:.6g} s", file, from, to);
  job.scratch = "span.h5";
  job.steps = {cut,
               step,
               {"report", "{folder}/result.json", "-o", "{folder}/report.html", "--language", language_of(body)},
               {"report", "{folder}/result.json", "--figure", "{folder}/figure.svg"}};
  return started(context, request, std::move(job));
}

/// The recording in another format, as a new file of the folder.
HttpResponse convert_to(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto file = member<std::string>(body, "file", ""), to = member<std::string>(body, "to", "");
  const auto path = existing(context, file);
  require_file_name(to);
  if (!format_to_write(to).writer) throw Error{Error::Kind::bad_input, say("'{}' cannot be written", to)};
  Job job;
  job.kind = "convert";
  job.title = file + ": " + to;
  Job::Step step{"convert", path, "-o", "{folder}/" + to, "--quiet"};
  add_sets(sets_of(member<std::vector<std::string>>(body, "set", {})), step);
  job.steps = {step};
  return started(context, request, std::move(job));
}

/// The error model of a result subtracted from a recording of the folder, and what that did as a result to look at.
HttpResponse compensate_recording(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto result = member<std::string>(body, "result", ""), file = member<std::string>(body, "recording", "");
  const auto plan = member<std::string>(body, "plan", "");
  Job::Step step{
      "compensate", existing(context, result),   existing(context, file), "--quiet", "-o", "{folder}/compensated.h5",
      "--save",     "{folder}/compensation.json"};
  if (!plan.empty()) step.insert(step.end(), {"--plan", existing(context, plan)});
  add_sets(sets_of(member<std::vector<std::string>>(body, "set", {})), step);
  Job job;
  job.kind = "compensate";
  job.title = fmt::format("{}: {}", fs::path(result).filename().string(), file);
  job.steps = {step};
  return started(context, request, std::move(job));
}

HttpResponse list_jobs(Context& context, const HttpRequest& request) {
  const auto latest = context.feed.latest();  // before the jobs: what changes in between comes as an event
  Json jobs = Json::array();
  for (const Job& job : context.jobs.all()) jobs.push_back(Json::parse(to_json(job)));
  return said_response(request, {{"event", latest}, {"jobs", jobs}});
}

HttpResponse cancel(Context& context, const HttpRequest& request) {
  const auto id = required(request, "id");
  if (context.jobs.find(id).id.empty()) throw Error{Error::Kind::unsupported, say("there is no job '{}'", id)};
  return json_response({{"cancelled", context.jobs.cancel(id)}});
}

std::string type_of(const std::string& name) {
  const auto extension = fs::path(name).extension().string();
  if (extension == ".html") return "text/html; charset=utf-8";
  if (extension == ".svg") return "image/svg+xml";
  if (extension == ".json") return "application/json";
  if (extension == ".csv") return "text/csv; charset=utf-8";
  return "application/octet-stream";
}

/// A result of a job. A page runs in a sandbox: it cannot ask the server as the user can.
HttpResponse job_file(Context& context, const HttpRequest& request) {
  const auto name = required(request, "name");
  HttpResponse response;
  response.more = context.jobs.reader_of(required(request, "id"), name);
  if (!response.more) throw Error{Error::Kind::unsupported, say("the job has no file '{}'", name)};
  response.type = type_of(name);
  response.headers.emplace_back(
      "Content-Security-Policy",
      "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline'; "
      "style-src 'unsafe-inline'; img-src data:; font-src data:");
  if (response.type == "application/octet-stream" || response.type.starts_with("text/csv"))
    response.headers.emplace_back("Content-Disposition", "attachment");
  return response;
}

HttpResponse events(Context& context, const HttpRequest& request) {
  HttpResponse response;
  response.type = "text/event-stream";
  response.events = {std::shared_ptr<void>(), &context.feed};
  response.seen = last_event_of(request).value_or(context.feed.latest());
  say_events(request, response);
  return response;
}

}  // namespace

std::vector<Route> job_routes() {
  constexpr std::uint64_t small = 1 << 16;
  return {{"GET", "/api/jobs", list_jobs},
          {"GET", "/api/jobs/file", job_file},
          {.method = "POST", .path = "/api/jobs/cancel", .answer = cancel, .body_limit = small},
          {.method = "POST", .path = "/api/jobs/identify", .answer = identify, .body_limit = small},
          {.method = "POST", .path = "/api/jobs/noise", .answer = noise, .body_limit = small},
          {.method = "POST", .path = "/api/jobs/convert", .answer = convert_to, .body_limit = small},
          {.method = "POST", .path = "/api/jobs/compensate", .answer = compensate_recording, .body_limit = small},
          {"GET", "/api/events", events}};
}

}  // namespace tumble::routes
