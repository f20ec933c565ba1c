#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/text.hpp"
#include "tumble/serve/guard.hpp"
#include "tumble/serve/http_server.hpp"
#include "tumble/serve/jobs.hpp"
#include "tumble/serve/live_runs.hpp"
#include "tumble/serve/predictions.hpp"
#include "tumble/serve/recording_cache.hpp"
#include "tumble/serve/result_cache.hpp"
#include "tumble/serve/stops.hpp"
#include "tumble/serve/workbench.hpp"
#include "tumble/units/error.hpp"

namespace tumble::routes {

using Json = nlohmann::ordered_json;

/// State from which the answers are made.
struct Context {
  WorkbenchOptions options;
  Guard guard;
  EventFeed feed;
  Jobs jobs;
  RecordingCache recordings;
  LiveRuns runs = {};
  Stops stops = {};
  ResultCache results;
  Predictions predictions;

  explicit Context(const WorkbenchOptions& given);
};

/// One method and path of the server.
struct Route {
  std::string method, path;
  HttpResponse (*answer)(Context& context, const HttpRequest& request);
  bool open = false;             ///< without the token
  std::uint64_t body_limit = 0;  ///< [bytes]
  bool body_to_file = false;     ///< into the folder of uploads
  std::optional<Right> role{};   ///< what its user must be allowed to do; not given: read for GET, operate for POST
  Lane lane = Lane::usual;       ///< of orders to a run, those to stop it go a way of their own
};

/// Right that a user needs for this route. The workbench asks it before any body is read.
Right role_of(const Route& route);

std::vector<Route> page_routes();
std::vector<Route> session_routes();
std::vector<Route> recording_routes();
std::vector<Route> view_routes();
std::vector<Route> job_routes();
std::vector<Route> archive_routes();
std::vector<Route> archive_chart_routes();        ///< part of archive_routes()
std::vector<Route> archive_certificate_routes();  ///< part of archive_routes()
std::vector<Route> station_routes();
std::vector<Route> station_run_routes();
std::vector<Route> result_routes();
std::vector<Route> plan_routes();
std::vector<Route> plan_view_routes();

HttpResponse json_response(const Json& json, unsigned status = 200);
/// {"problems": [...]} with the status that the kind of error has.
HttpResponse problem_response(const Error& error);
HttpResponse problem_response(unsigned status, const Problem& problem);
HttpResponse problem_response(unsigned status, const Problems& problems);

/// A job of the user who asks, in the queue; its identifier as the answer.
HttpResponse started(Context& context, const HttpRequest& request, Job job);

/// Who asks; empty: whoever has the link, and who shows nothing.
std::string user_of(const Context& context, const HttpRequest& request);

/// The run that the body of an order says must end, by its safe list; nothing: it says something else.
std::optional<std::string> run_to_be_stopped(const HttpRequest& request);

/// Why a password did not let somebody in, for people.
HttpResponse password_refusal(const PasswordCheck& check);

/// The body as an object of JSON. Throws Error::bad_input.
Json body_of(const HttpRequest& request);
/// A text of the body; empty where it is absent. Throws Error::bad_input where it is no text.
std::string text_in(const Json& body, const char* name);

/// A parameter of the query [as written]. Throws Error::bad_input where it is missing, or is no number.
std::string required(const HttpRequest& request, std::string_view name);
/// One that may be absent; empty then.
std::string optional(const HttpRequest& request, std::string_view name);
/// One that is a number [as written].
double required_number(const HttpRequest& request, std::string_view name);
/// Number of the last event that was seen: the header Last-Event-ID, or the parameter after; 0: no event has had it.
std::optional<std::uint64_t> last_event_of(const HttpRequest& request);
std::vector<std::string> all_of(const HttpRequest& request, std::string_view name);

/// The parameter language: English where it is absent. Throws Error::unsupported for another language.
Language language_asked(const HttpRequest& request);
/// Findings of a result or an inspection, their messages in this language.
Json findings_in(Language language, Json findings);

/// An answer whose sentences for people, those under problems, message, doing, text, reason and ending_text, are said
/// in the language that is asked for.
HttpResponse said_response(const HttpRequest& request, Json json, unsigned status = 200);
/// A refusal in the language that is asked for; English where that is unknown.
void say_refusal(const HttpRequest& request, HttpResponse& response);
/// Events whose sentences for people are said in the language that is asked for.
void say_events(const HttpRequest& request, HttpResponse& response);

/// The file that a name means. Throws Error::unsupported where it is not there, Error::bad_input.
std::string existing(const Context& context, const std::string& name);
/// A message with files named from the folder of the workbench on.
std::string named_from_folder(const Context& context, std::string message);

/// The file that a plan is or will be: in the folder or in one below it, "x.toml". Throws Error::bad_input.
std::string place_of_plan(const Context& context, const std::string& name);

/// How a file is to be read: the parameters set=key=value. Throws Error::bad_input for a key that is not about columns
/// and times of a file.
Sets sets_of(const std::vector<std::string>& texts);

/// `value_si` [SI] in the unit, as JSON; null where it is not finite.
Json number(double value_si, const Unit& unit);
/// A value [u] with digits down to 1e-4 of `scale` [u].
std::string number_text(double value, double scale);
/// Units that people use for this dimension; the first is that of the file.
std::vector<std::string> units_like(const Unit& unit);

}  // namespace tumble::routes
