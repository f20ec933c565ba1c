// One run: its state, what happens, and orders.
#include <cmath>
#include <filesystem>

#include "tumble/desk/run_desk.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/typeset.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/station.hpp"

namespace tumble::routes {

namespace fs = std::filesystem;

namespace {

constexpr double patience_of_order = 5.0, patience_of_stop = 1.5;  ///< [s] until a run must have answered

/// The folder of a run. A rehearsal and a run that has just begun have one without a store for a moment.
std::string folder_of_run(const Context& context, const HttpRequest& request) {
  const auto folder = existing(context, required(request, "run"));
  if (!fs::is_directory(folder)) throw Error{Error::Kind::unsupported, "there is no run of this name"};
  return folder;
}

HttpResponse run_state(Context& context, const HttpRequest& request) {
  const auto folder = folder_of_run(context, request);
  Json state = Json::parse(context.runs.state_of(folder));
  Json files = Json::array();
  std::error_code failed;
  const auto add = [&](const fs::path& path) {
    if (path.extension() == ".h5") files.push_back(fs::relative(path, context.options.folder, failed).generic_string());
  };
  for (const auto& entry : fs::directory_iterator(folder, failed)) add(entry.path());
  if (fs::exists(folder + ".h5", failed)) add(folder + ".h5");
  state["recordings"] = files;
  return said_response(request, state);
}

/// What happens at a run. An id is the sequence number of the store up to which everything was sent.
HttpResponse run_events(Context& context, const HttpRequest& request) {
  HttpResponse response;
  response.type = "text/event-stream";
  response.events = context.runs.feed_of(folder_of_run(context, request));
  const auto last = last_event_of(request);
  response.seen = last ? response.events->seen_by_id(*last) : response.events->latest();
  say_events(request, response);
  return response;
}

Json style_json(std::size_t series) {
  const auto style = style_of_series(series);
  return {{"colour", style.colour}, {"dark", style.dark}, {"dashes", style.dashes}};
}

/// The standard uncertainties that the plan of a run will have reached at its end; 202 until they are known. A plan
/// whose method has no prediction has no rows. With the styles of the estimate and of this line.
HttpResponse run_predicted(Context& context, const HttpRequest& request) {
  const auto folder = folder_of_run(context, request), path = folder + "/plan.toml";
  Json rows = Json::array();
  if (fs::exists(path)) {
    const std::string text = read_text_file(path);
    const auto answer = context.predictions.ask(user_of(context, request), "run " + folder, {{text, path}}).front();
    if (!answer.ready) return json_response({{"ready", false}, {"rows", rows}}, 202);
    for (std::size_t i = 0; answer.estimate && i < answer.estimate->parameters.size(); ++i) {
      const auto& parameter = answer.estimate->parameters[i];
      const double sd = standard_uncertainty(*answer.estimate, i);
      if (!std::isfinite(sd)) continue;
      const double shown = parameter.unit.difference_from_si(sd);
      rows.push_back({{"name", parameter.name},
                      {"unit", parameter.unit.text()},
                      {"sd", shown},
                      {"text", number_in_characters(general(shown, 3))}});
    }
  }
  return json_response({{"ready", true}, {"rows", rows}, {"styles", {style_json(0), style_json(1)}}});
}

/// Pause, resume, stop, abort, or the answer to a question. The run itself says whether it takes it.
HttpResponse run_order(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto folder = existing(context, plain_text_in(body, "run"));
  const auto order = plain_text_in(body, "order"), who = who_of(context, request, body);
  if (order == "stop") {
    context.stops.stop(folder, who.empty() ? "the workbench" : who, patience_of_stop, request.came);
    return json_response({{"taken", true}});
  }
  Json asked{{"order", order}, {"who", who}};
  if (order == "answer") {
    if (!body.contains("prompt") || !body["prompt"].is_number_integer())
      throw Error{Error::Kind::bad_input, "'prompt' must be the number of a question"};
    asked["prompt"] = body["prompt"];
    asked["choice"] = plain_text_in(body, "choice");
  }
  return said_response(request, Json::parse(ask_desk(folder, asked.dump(), patience_of_order)));
}

}  // namespace

std::optional<std::string> run_to_be_stopped(const HttpRequest& request) {
  try {
    const Json body = body_of(request);
    const auto order = text_in(body, "order");
    if (order == "stop" || order == "abort") return text_in(body, "run");
  } catch (const std::exception&) {  // the route says what is wrong with it
  }
  return std::nullopt;
}

std::vector<Route> station_run_routes() {
  constexpr std::uint64_t small = 1 << 16;
  return {
      {.method = "GET", .path = "/api/station/run", .answer = run_state, .lane = Lane::looks},
      {.method = "GET", .path = "/api/station/run/events", .answer = run_events, .lane = Lane::looks},
      {"GET", "/api/station/run/predicted", run_predicted},
      {.method = "POST", .path = "/api/station/order", .answer = run_order, .body_limit = small, .lane = Lane::orders}};
}

}  // namespace tumble::routes
