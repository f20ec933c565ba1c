#include "tumble/serve/workbench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <new>

#include "tumble/formats/confinement.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace fs = std::filesystem;
using routes::Route;

namespace routes {

Context::Context(const WorkbenchOptions& given)
    : options(given),
      guard{given.token,    given.host,
            given.port,     given.tls,
            given.computer, given.users.empty() ? nullptr : std::make_shared<SignIn>(given.users, given.steady)},
      feed(given.first_event),
      jobs({given.program, given.folder.string(), given.state.string(), 2, given.clock}, feed),
      recordings(given.cache, jobs),
      predictions(given.program, 2) {}

Right role_of(const Route& route) { return route.role.value_or(route.method == "GET" ? Right::read : Right::operate); }

}  // namespace routes

namespace {

std::vector<Route> all_routes() {
  std::vector<Route> all;
  for (const auto& some :
       {routes::page_routes(), routes::session_routes(), routes::recording_routes(), routes::view_routes(),
        routes::job_routes(), routes::plan_routes(), routes::plan_view_routes(), routes::result_routes(),
        routes::station_routes(), routes::station_run_routes(), routes::archive_routes()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

/// Uploads that a workbench which was killed left; no other one serves the folder.
void remove_unfinished_uploads(const fs::path& folder) {
  std::error_code failed;
  if (fs::is_symlink(folder / "uploads", failed)) return;
  for (const auto& entry : fs::directory_iterator(folder / "uploads", failed)) {
    const auto name = entry.path().filename().string();
    if (name.starts_with(".upload.") && name.ends_with(".part") && !entry.is_symlink(failed) &&
        entry.is_regular_file(failed))
      fs::remove(entry.path(), failed);
  }
}

}  // namespace

struct Workbench::State {
  FolderClaim claim;
  Confinement confinement;  ///< before all that opens files
  std::vector<Route> routes = all_routes();
  std::atomic<std::uint64_t> uploads = 0;
  routes::Context context;

  explicit State(const WorkbenchOptions& options)
      : claim(options.folder), confinement(options.folder), context(options) {
    remove_unfinished_uploads(options.folder);
  }

  /// HEAD is answered as GET is, without the body.
  const Route* route_of(const HttpRequest& request) const {
    const std::string method = request.method == "HEAD" ? "GET" : request.method;
    const auto found = std::ranges::find_if(
        routes, [&](const Route& route) { return route.path == request.path && route.method == method; });
    return found == routes.end() ? nullptr : &*found;
  }

  HttpResponse unknown(const HttpRequest& request) const {
    std::string allowed;
    for (const Route& route : routes)
      if (route.path == request.path) allowed += (allowed.empty() ? "" : ", ") + route.method;
    if (allowed.empty()) return routes::problem_response(404, "there is nothing at this address");
    auto response = routes::problem_response(405, say("this address is asked by {}", Name{allowed}));
    response.headers.emplace_back("Allow", allowed);
    return response;
  }

  std::optional<HttpResponse> refusal(const HttpRequest& head, const std::optional<Session>& session) const {
    if (!context.guard.names_this_server(head))
      return routes::problem_response(421, "the name of the server in the request is not one of this server");
    if (context.guard.is_cross_site(head)) return routes::problem_response(403, "the request comes from another site");
    const Route* route = route_of(head);
    if (!route) return unknown(head);
    if (route->open) return std::nullopt;
    if (!session)
      return routes::problem_response(
          401, context.guard.users ? "sign in first" : "open the workbench by the link that the program printed");
    const Right needed = routes::role_of(*route);
    if (!session->may(needed)) return routes::problem_response(403, say("this needs the role '{}'", name(needed)));
    return std::nullopt;
  }

  /// A disk that does not answer keeps who asks this waiting.
  std::optional<HttpResponse> refusal_of_folder(const Route& route) const {
    std::error_code failed;
    if (route.open || fs::is_directory(context.options.folder, failed)) return std::nullopt;
    return routes::problem_response(503, "the folder of the workbench was removed or has another name now");
  }

  /// Stops wait for those of the same run alone.
  Way way_of(const HttpRequest& request) const {
    const Route* route = route_of(request);
    if (!route) return {};
    if (route->lane != Lane::orders) return {route->lane};
    const auto stopped = routes::run_to_be_stopped(request);
    return stopped ? Way{Lane::stops, "run " + *stopped} : Way{Lane::orders};
  }

  /// Who asks for this request. Stops wait for no disk: what was known of their user a second ago is enough.
  std::optional<Session> session_of(const HttpRequest& request) const {
    return way_of(request).lane == Lane::stops ? context.guard.known_session_of(request)
                                               : context.guard.session_of(request);
  }

  /// Events go on while the route would answer who asked for them.
  void limit_events(const HttpRequest& request, HttpResponse& response) const {
    if (!response.events) return;
    response.allowed = [this, request] { return !refusal(request, context.guard.known_session_of(request)); };
  }

  /// The file that an upload becomes, for now under a name that nobody sees.
  std::optional<HttpResponse> open_upload(const HttpRequest& head, std::shared_ptr<BodyFile>& file) {
    auto refused = refusal_of_folder(*route_of(head));
    if (!refused) try {
        const auto* name = find_query(head, "name");
        require_file_name(name ? *name : "");
        const fs::path folder = context.options.folder / "uploads";
        fs::create_directories(folder);
        inside(context.options.folder, "uploads");
        file = std::make_shared<BodyFile>(
            (folder / fmt::format(".upload.{}.{}.part", context.options.first_event, uploads++)).string());
      } catch (const Error& error) {
        refused = refusal_of_error(error);
      } catch (const fs::filesystem_error& error) {
        refused = routes::problem_response(507, system_reason(error.code()));
      }
    if (refused) routes::say_refusal(head, *refused), add_safety(*refused);
    return refused;
  }

  BodyPlan admit(const HttpRequest& head) {
    BodyPlan plan;
    const auto session = context.guard.known_session_of(head);
    if (session) plan.party = session->user.empty() ? "the link" : "user " + session->user;
    plan.refusal = refusal(head, session);
    if (plan.refusal) {
      routes::say_refusal(head, *plan.refusal), add_safety(*plan.refusal);
      return plan;
    }
    const Route& route = *route_of(head);
    plan.limit = route.body_to_file ? context.options.upload_limit : route.body_limit;
    if (route.body_to_file)
      plan.open = [this, head](std::shared_ptr<BodyFile>& file) { return open_upload(head, file); };
    return plan;
  }

  /// Names in refusals are those of the folder: where it lies on the computer is not said.
  HttpResponse refusal_of_error(const Error& error) const {
    auto problems = error.problems;
    for (auto& problem : problems) problem = named_from(context.options.folder.string(), problem);
    return routes::problem_response(Error{error.kind, problems});
  }

  HttpResponse answer(const HttpRequest& request) {
    HttpResponse response;
    try {
      // Again: who sent a long body may have signed out meanwhile.
      if (auto refused = refusal(request, session_of(request)))
        response = std::move(*refused);
      else if (auto missing = refusal_of_folder(*route_of(request)))
        response = std::move(*missing);
      else
        response = route_of(request)->answer(context, request);
      limit_events(request, response);
    } catch (const Error& error) {
      response = refusal_of_error(error);
    } catch (const fs::filesystem_error& error) {
      response = routes::problem_response(507, say("the folder cannot be written: {}", system_reason(error.code())));
    } catch (const std::bad_alloc&) {
      response = routes::problem_response(503, "there is not enough memory for this answer");
    } catch (const std::exception& error) {
      response = routes::problem_response(500, say("internal: {}", error.what()));
    }
    routes::say_refusal(request, response);
    add_safety(response);
    return response;
  }
};

Workbench::Workbench(const WorkbenchOptions& options) : state_(std::make_unique<State>(options)) {}

Workbench::~Workbench() = default;

HttpHandler Workbench::handler() {
  return {.admit = [this](const HttpRequest& head) { return state_->admit(head); },
          .answer = [this](const HttpRequest& request) { return state_->answer(request); },
          .way = [this](const HttpRequest& request) { return state_->way_of(request); },
          .finish =
              [](const HttpRequest& request, HttpResponse& response) {
                routes::say_refusal(request, response);
                add_safety(response);
              }};
}

void Workbench::set_port(unsigned port) { state_->context.guard.port = port; }

std::vector<std::string> workbench_routes() {
  std::vector<std::string> all;
  for (const Route& route : all_routes()) all.push_back(say("{} {}", Name{route.method}, Name{route.path}));
  return all;
}

}  // namespace tumble
