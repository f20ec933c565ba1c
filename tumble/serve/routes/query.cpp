#include "tumble/serve/routes/query.hpp"

#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::routes {

std::string user_of(const Context& context, const HttpRequest& request) {
  const auto session = context.guard.known_session_of(request);
  return session ? session->user : "";
}

std::string required(const HttpRequest& request, std::string_view name) {
  if (const auto* value = find_query(request, name)) return *value;
  throw Error{Error::Kind::bad_input, say("the parameter '{}' is missing", name)};
}

std::string optional(const HttpRequest& request, std::string_view name) {
  const auto* value = find_query(request, name);
  return value ? *value : std::string();
}

/// Deeper values are refused while they are read: what copies or writes them calls itself for each level.
Json body_of(const HttpRequest& request) {
  static constexpr int deepest = 64;
  const auto look = [](int depth, Json::parse_event_t, const Json&) {
    if (depth <= deepest) return true;
    throw Error{Error::Kind::bad_input, say("the body is nested deeper than {} levels", deepest)};
  };
  const Json body = Json::parse(request.body, look, false);
  if (!body.is_object()) throw Error{Error::Kind::bad_input, "the body must be an object of JSON"};
  return body;
}

std::string text_in(const Json& body, const char* name) {
  const auto found = body.find(name);
  if (found == body.end()) return "";
  if (!found->is_string()) throw Error{Error::Kind::bad_input, say("'{}' must be a text", name)};
  return found->get<std::string>();
}

double required_number(const HttpRequest& request, std::string_view name) {
  const auto text = required(request, name);
  const auto value = as_number<double>(text);
  if (!value || !std::isfinite(*value))
    throw Error{Error::Kind::bad_input, say("the parameter '{}' must be a number, not '{}'", name, text)};
  return *value;
}

std::optional<std::uint64_t> last_event_of(const HttpRequest& request) {
  const auto last = request.headers.find("last-event-id");
  const std::string seen = last != request.headers.end() ? last->second : optional(request, "after");
  if (seen.empty()) return std::nullopt;
  const bool sent_by_us = seen.size() < 19 && is_digits(seen);
  return sent_by_us ? as_number<std::uint64_t>(seen).value_or(0) : 0;
}

std::vector<std::string> all_of(const HttpRequest& request, std::string_view name) {
  std::vector<std::string> values;
  for (const auto& [key, value] : request.query)
    if (key == name) values.push_back(value);
  return values;
}

Language language_asked(const HttpRequest& request) {
  const auto* code = find_query(request, "language");
  if (code == nullptr || *code == "en") return Language::english;
  if (*code == "zh") return Language::chinese;
  throw Error{Error::Kind::unsupported, say("there is no language '{}' (languages: en, zh)", *code)};
}

}  // namespace tumble::routes
