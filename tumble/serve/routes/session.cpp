#include <fmt/format.h>

#include <cmath>

#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"

namespace tumble::routes {

HttpResponse password_refusal(const PasswordCheck& check) {
  using State = PasswordCheck::State;
  const auto seconds = static_cast<long>(std::ceil(check.pause));
  HttpResponse response;
  if (check.state == State::paused) {
    response = problem_response(429, say("too many wrong passwords: try again in {} s", seconds));
    response.headers.emplace_back("Retry-After", std::to_string(seconds));
  } else if (check.remaining == 0) {
    response = problem_response(403, say("the name or the password is wrong; try again in {} s", seconds));
  } else {
    response =
        problem_response(403, say("the name or the password is wrong; attempts before a pause: {}", check.remaining));
  }
  return response;
}

namespace {

Json json_of(const Guard& guard, const std::optional<Session>& session) {
  Json roles = Json::array();
  if (session)
    for (const Right right : all_rights())
      if (session->may(right)) roles.push_back(name(right));
  return {{"users", guard.users != nullptr},
          {"open", session.has_value()},
          {"user", session ? session->user : ""},
          {"roles", roles}};
}

/// Whether a page must show a sign-in, and what its user may do.
HttpResponse session(Context& context, const HttpRequest& request) {
  return json_response(json_of(context.guard, context.guard.session_of(request)));
}

/// The token of the link for a cookie that no script can read.
HttpResponse open_by_token(const Context& context, const std::string& token) {
  if (!context.guard.token.empty() && !context.guard.is_token(token))
    return problem_response(401, "the token is not that of this server");
  auto response = json_response({{"open", true}});
  response.headers.emplace_back("Set-Cookie", context.guard.cookie(context.guard.begin_by_link()));
  return response;
}

/// Who signs in again, or as somebody else, leaves the session before.
HttpResponse sign_in(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  SignIn& users = *context.guard.users;
  const auto user = text_in(body, "name");
  const auto check = users.check(user, text_in(body, "password"));
  if (check.state != PasswordCheck::State::right) return password_refusal(check);
  users.end(context.guard.secret_of(request));
  const auto secret = users.begin(user);
  auto response = json_response({{"open", true}, {"wrong_before", check.before}});
  response.headers.emplace_back("Set-Cookie", context.guard.cookie(secret));
  return response;
}

HttpResponse open_session(Context& context, const HttpRequest& request) {
  if (context.guard.users) return sign_in(context, request);
  const Json body = Json::parse(request.body, nullptr, false);
  const bool shown = body.is_object() && body.contains("token") && body["token"].is_string();
  return open_by_token(context, shown ? body["token"].get<std::string>() : std::string());
}

HttpResponse end_session(Context& context, const HttpRequest& request) {
  context.guard.end_session(request);
  auto response = json_response({{"open", false}});
  response.headers.emplace_back("Set-Cookie", context.guard.cookie(""));
  return response;
}

}  // namespace

std::vector<Route> session_routes() {
  constexpr std::uint64_t small = 4096;
  return {
      {.method = "GET", .path = "/api/session", .answer = session, .open = true},
      {.method = "POST",
       .path = "/api/session",
       .answer = open_session,
       .open = true,
       .body_limit = small,
       .lane = Lane::sign_in},
      {.method = "POST", .path = "/api/session/end", .answer = end_session, .body_limit = small, .role = Right::read}};
}

}  // namespace tumble::routes
