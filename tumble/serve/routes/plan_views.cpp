#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/language/said.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/tasks/catalogue.hpp"
#include "tumble/tasks/plan_motion.hpp"
#include "tumble/tasks/plan_text.hpp"

namespace tumble::routes {

namespace {

constexpr std::uint64_t two_plans = 4'000'000;  ///< [bytes]
constexpr std::size_t most_instants = 2000;

/// Methods, models and rigs as `tumble list --json` has them, in each language.
std::map<std::pair<std::string, Language>, Json> catalogues_by_language() {
  std::map<std::pair<std::string, Language>, Json> all;
  for (const char* kind : {"methods", "models", "rigs"})
    for (const Language language : {Language::english, Language::chinese})
      all.emplace(std::pair{kind, language}, Json::parse(catalogue_json(kind, language)));
  return all;
}

const Json& catalogue_of(const std::string& kind, Language language) {
  static const auto all = catalogues_by_language();
  const auto found = all.find({kind, language});
  if (found == all.end())
    throw Error{Error::Kind::unsupported, say("there is no list of '{}' (lists: methods, models, rigs)", kind)};
  return found->second;
}

/// Names and summaries of a kind, or all that one entry says of itself.
HttpResponse catalogue(Context&, const HttpRequest& request) {
  const auto& entries = catalogue_of(required(request, "kind"), language_asked(request));
  const auto* name = find_query(request, "name");
  Json list = Json::array();
  for (const auto& entry : entries) {
    if (name && entry["name"] == *name) return json_response(entry);
    list.push_back({{"name", entry["name"]}, {"summary", entry["summary"]}});
  }
  if (name) throw Error{Error::Kind::unsupported, say("there is no '{}' in this list", *name)};
  return json_response(list);
}

double number_in(const Json& body, const char* name) {
  if (!body.contains(name) || !body[name].is_number() || !std::isfinite(body[name].get<double>()))
    throw Error{Error::Kind::bad_input, say("'{}' must be a number", name)};
  return body[name].get<double>();
}

/// To what a picture needs.
double rounded_to(double value, double step) { return std::round(value / step) * step + 0.0; }

Json vector_of(const Vector3& v, double step) {
  return {rounded_to(v.x, step), rounded_to(v.y, step), rounded_to(v.z, step)};
}

/// The axes of a part in level axes one after the other, and its origin [m].
Json placement_of(const PartPlacement& placement) {
  Json numbers = Json::array();
  for (const auto& row : {placement.part_from_level.x, placement.part_from_level.y, placement.part_from_level.z})
    for (const double cosine : {row.x, row.y, row.z}) numbers.push_back(rounded_to(cosine, 1e-6));
  for (const double metre : {placement.origin.x, placement.origin.y, placement.origin.z})
    numbers.push_back(rounded_to(metre, 1e-6));
  return numbers;
}

/// "90.0 deg", at an instant each.
Json course_of(const PlanMotion::AxisCourse& course) {
  Json texts = Json::array();
  for (const double value : course.values) {
    const double shown = course.unit.from_si(value);
    texts.push_back(fmt::format("{:.1f} {}", rounded_to(shown, 0.1), course.unit.text()));
  }
  return {{"name", course.name}, {"values", texts}};
}

/// The rig and the instrument at some instants of a power-up, and what points where.
HttpResponse motion(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto path = place_of_plan(context, text_in(body, "file"));
  const double from = number_in(body, "from"), step = number_in(body, "step"), count = number_in(body, "count");
  if (!(count >= 1.0 && count <= most_instants))
    throw Error{Error::Kind::bad_input, say("'count' must be from 1 to {}", most_instants)};
  const auto moved = motion_of(plan_of_text(text_in(body, "text"), path), static_cast<int>(number_in(body, "run")),
                               from, step, static_cast<std::size_t>(count));
  Json parts = Json::array(), axes = Json::array();
  for (const auto& part : moved.parts) {
    Json at = Json::array();
    for (const auto& placement : part.at) at.push_back(placement_of(placement));
    parts.push_back({{"name", part.name}, {"axis", vector_of(part.axis, 1e-6)}, {"slides", part.slides}, {"at", at}});
  }
  for (const auto& axis : moved.axes) axes.push_back(course_of(axis));
  return json_response({{"from", from},
                        {"step", step},
                        {"parts", parts},
                        {"axes", axes},
                        {"settled", moved.settled},
                        {"earth_rate", vector_of(moved.earth_rate, 1e-12)},
                        {"gravity", vector_of(-1.0 * moved.specific_force, 1e-9)}});
}

/// A parameter before the test, beside that of the saved plan.
Json row_of(const Estimate& now, std::size_t index, const Estimate* saved) {
  const auto& parameter = now.parameters[index];
  const double sd = shown(now, index).sd;
  Json row{{"name", parameter.name},
           {"symbol", parameter.symbol},
           {"unit", parameter.unit.text()},
           {"description", parameter.description},
           {"sd", general(sd, 3)},
           {"saved", ""},
           {"ratio", ""},
           {"change", "none"}};
  if (!saved) return row;
  const auto before = std::ranges::find(saved->parameters, parameter.name, &Parameter::name);
  if (before == saved->parameters.end()) {
    row["change"] = "new";
    return row;
  }
  const auto other = static_cast<std::size_t>(before - saved->parameters.begin());
  const double saved_sd = parameter.unit.from_si(standard_uncertainty(*saved, other)) - parameter.unit.from_si(0.0);
  row["saved"] = general(saved_sd, 3);
  if (!(sd > 0.0 && saved_sd > 0.0) || !std::isfinite(sd / saved_sd)) return row;
  row["ratio"] = fmt::format("{:.3g}", sd / saved_sd);
  row["change"] = std::abs(std::log(sd / saved_sd)) < 0.005 ? "same" : sd > saved_sd ? "worse" : "better";
  return row;
}

Json comparison_of(const Estimate& now, const Estimate* saved, Language language) {
  Json rows = Json::array(), lost = Json::array();
  std::map<std::string, int> changes;
  for (std::size_t i = 0; i < now.parameters.size(); ++i) {
    rows.push_back(row_of(now, i, saved));
    ++changes[rows.back()["change"].get<std::string>()];
  }
  if (saved)
    for (const auto& parameter : saved->parameters)
      if (!find_parameter(now, parameter.name)) lost.push_back(parameter.name);
  return {{"ready", true},
          {"rows", rows},
          {"lost", lost},
          {"worse", changes["worse"] + static_cast<int>(lost.size())},
          {"better", changes["better"] + changes["new"]},
          {"findings", findings_in(language, Json::parse(to_json(now.findings)))},
          {"problems", Json::array()}};
}

/// The uncertainties that the plan will reach, beside those of the saved one; 202 until they are known.
HttpResponse predict(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto path = place_of_plan(context, text_in(body, "file"));
  const auto text = text_in(body, "text"), saved = text_in(body, "saved");
  std::vector<Predictions::Question> questions{{text, path}};
  if (!saved.empty() && saved != text) questions.push_back({saved, path});
  const auto answers = context.predictions.ask(user_of(context, request), text_in(body, "page"), questions);
  const bool ready = std::ranges::all_of(answers, &Predictions::Answer::ready);
  if (!ready) return json_response({{"ready", false}}, 202);
  if (!answers[0].estimate) {
    Json problems = Json::array();
    for (const auto& problem : answers[0].problems)
      problems.push_back(in_language(language_asked(request), named_from(context.options.folder.string(), problem)));
    return json_response({{"ready", true},
                          {"rows", Json::array()},
                          {"lost", Json::array()},
                          {"worse", 0},
                          {"better", 0},
                          {"findings", Json::array()},
                          {"problems", problems}});
  }
  return json_response(comparison_of(*answers[0].estimate, answers.size() > 1 ? answers[1].estimate.get() : nullptr,
                                     language_asked(request)));
}

}  // namespace

std::vector<Route> plan_view_routes() {
  return {
      {"GET", "/api/catalogue", catalogue},
      {.method = "POST", .path = "/api/plan/motion", .answer = motion, .body_limit = two_plans, .role = Right::read},
      {.method = "POST", .path = "/api/plan/predict", .answer = predict, .body_limit = two_plans, .role = Right::read}};
}

}  // namespace tumble::routes
