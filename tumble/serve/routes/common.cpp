#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "tumble/core/message_in.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/report/report.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::routes {

Right role_of(const Route& route) { return route.role.value_or(route.method == "GET" ? Right::read : Right::operate); }

HttpResponse json_response(const Json& json, unsigned status) {
  HttpResponse response;
  response.status = status;
  response.body = json.dump(-1, ' ', false, Json::error_handler_t::replace);
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

std::string user_of(const Context& context, const HttpRequest& request) {
  const auto session = context.guard.known_session_of(request);
  return session ? session->user : "";
}

HttpResponse started(Context& context, const HttpRequest& request, Job job) {
  job.owner = user_of(context, request);
  return json_response({{"job", context.jobs.start(std::move(job))}}, 202);
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

Json findings_in(Language language, Json findings) {
  if (language == Language::english || !findings.is_array()) return findings;
  const Findings all = findings_from_json(findings.dump(), "findings");
  for (std::size_t i = 0; i < all.size(); ++i) findings[i]["message"] = message_in(language, all[i]);
  return findings;
}

std::string existing(const Context& context, const std::string& name) {
  try {
    return inside(context.options.folder, name).string();
  } catch (const Error& error) {
    if (error.kind == Error::Kind::bad_file) throw Error{Error::Kind::unsupported, error.problems};
    throw;
  }
}

Sets sets_of(const std::vector<std::string>& texts) {
  static const std::vector<std::string> known{"rate",    "missing", "columns", "segment_column", "topic",
                                              "decimal", "time",    "date",    "encoding",       "skip"};
  Sets sets;
  for (const auto& text : texts) {
    auto set = key_and_value(text);
    if (!set || (std::ranges::find(known, set->first) == known.end() && !set->first.starts_with("unit.")))
      throw Error{Error::Kind::bad_input,
                  say("'{}': what a file does not say is rate=100, missing=WORD, unit.COLUMN=deg/h, columns=..., "
                      "segment_column=COLUMN, topic=NAME, decimal=comma, time=COLUMN, date=dmy, encoding=NAME or "
                      "skip=LINES",
                      text)};
    sets.push_back(std::move(*set));
  }
  return sets;
}

Json number(double value_si, const Unit& unit) {
  if (!std::isfinite(value_si)) return nullptr;
  return as_number<double>(format_in(value_si, unit)).value_or(NAN);
}

std::string number_text(double value, double scale) {
  if (!std::isfinite(value)) return "";
  if (!(scale > 0.0) || !std::isfinite(scale)) return fmt::format("{:.9g}", value);
  const int last = static_cast<int>(std::floor(std::log10(scale))) - 4;
  if (std::abs(value) < std::pow(10.0, last)) return fmt::format("{:.2g}", value);
  const double size = std::log10(std::abs(value));
  if (last >= -12 && last <= 0 && size < 9.0) return fmt::format("{:.{}f}", value, -last);
  return fmt::format("{:.{}g}", value, std::clamp(static_cast<int>(std::floor(size)) - last + 1, 1, 17));
}

std::vector<std::string> units_like(const Unit& unit) {
  static const std::vector<std::string> usual{"deg/h",  "deg/s", "rad/s", "m/s^2", "g",    "mg", "ug", "deg",
                                              "arcsec", "rad",   "m/s",   "mm/s",  "degC", "K",  "s",  "ms",
                                              "pulse",  "V",     "mV",    "A",     "mA",   "T",  "uT", "Pa",
                                              "kPa",    "hPa",   "Hz",    "m",     "mm",   "1",  "%",  "ppm"};
  std::vector<std::string> like{unit.text()};
  for (const auto& text : usual)
    if (text != unit.text() && Unit::parse(text).dimension() == unit.dimension()) like.push_back(text);
  return like;
}

}  // namespace tumble::routes
