// What the server says in English, for people who asked for another language.
#include <algorithm>
#include <array>

#include "tumble/core/json_text.hpp"
#include "tumble/language/said.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"

namespace tumble::routes {

namespace {

constexpr std::string_view said_beside = "_said";  ///< "text_said" has the pattern and the values of "text"

bool is_for_people(const std::string& key) {
  static const std::array<std::string, 6> keys{"problems", "message", "doing", "text", "reason", "ending_text"};
  return std::ranges::find(keys, key) != keys.end();
}

void say_in(Language language, Json& json, bool for_people = false);

/// The members of an object. A sentence has its pattern and its values beside it; what has none is a text of a run that
/// an earlier version has stored.
void say_members_in(Language language, Json& json) {
  for (auto& [key, value] : json.items()) {
    if (key.ends_with(said_beside)) continue;
    if (const auto said = json.find(key + std::string(said_beside)); said != json.end())
      value = in_language(language, sentence_from_json(json_text(*said)));
    else
      say_in(language, value, is_for_people(key));
  }
}

void say_in(Language language, Json& json, bool for_people) {
  if (json.is_object() && json.contains("errors") && json.contains("problems")) {
    json["problems"] = in_language(language, coded_problems_from_json(json["errors"].dump()).problems);
    for (auto& [key, value] : json.items())
      if (key != "problems" && key != "errors") say_in(language, value, is_for_people(key));
  } else if (json.is_object())
    say_members_in(language, json);
  else if (json.is_array())
    for (auto& value : json) say_in(language, value, for_people);
  else if (for_people && json.is_string())
    json = said_in(language, json.get_ref<const std::string&>());
}

/// Events as they go over the wire, "data: {...}" among their lines.
std::string events_said_in(Language language, std::string_view events) {
  constexpr std::string_view data = "data: ";
  std::string said;
  while (!events.empty()) {
    const auto end = std::min(events.find('\n'), events.size() - 1) + 1;
    const auto line = events.substr(0, end);
    Json json = line.starts_with(data) ? Json::parse(line.substr(data.size()), nullptr, false) : Json();
    if (json.is_object()) {
      say_in(language, json);
      said.append(data).append(json_text(json)).append("\n");
    } else {
      said += line;
    }
    events.remove_prefix(end);
  }
  return said;
}

}  // namespace

HttpResponse said_response(const HttpRequest& request, Json json, unsigned status) {
  if (const Language language = language_asked(request); language != Language::english) say_in(language, json);
  return json_response(json, status);
}

void say_refusal(const HttpRequest& request, HttpResponse& response) {
  const auto* code = find_query(request, "language");
  if (response.status < 400 || !code || *code != code_of(Language::chinese)) return;
  Json json = Json::parse(response.body, nullptr, false);
  if (!json.is_object()) return;
  say_in(Language::chinese, json);
  response.body = json_response(json).body;
}

void say_events(const HttpRequest& request, HttpResponse& response) {
  const Language language = language_asked(request);
  if (language == Language::english) return;
  response.said = [language](const std::string& events) { return events_said_in(language, events); };
}

}  // namespace tumble::routes
