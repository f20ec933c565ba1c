#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tumble/serve/guard.hpp"
#include "tumble/serve/http_server.hpp"
#include "tumble/serve/jobs.hpp"
#include "tumble/serve/live_runs.hpp"
#include "tumble/serve/predictions.hpp"
#include "tumble/serve/recording_cache.hpp"
#include "tumble/serve/result_cache.hpp"
#include "tumble/serve/stops.hpp"
#include "tumble/serve/workbench.hpp"

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

}  // namespace tumble::routes
