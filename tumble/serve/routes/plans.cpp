#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <mutex>

#include "tumble/core/tables/document.hpp"
#include "tumble/core/tables/section.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/language/said.hpp"
#include "tumble/language/texts.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/tasks/plan_edit.hpp"
#include "tumble/tasks/plan_text.hpp"
#include "tumble/tasks/ready_plans.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::routes {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_plans = 1000;
constexpr std::uint64_t longest_plan = 1'000'000;  ///< [bytes]

/// What the list says of a file; null where it is no plan: it has neither a method nor a schedule.
Json listed_plan(const std::string& name, const fs::path& path) {
  try {
    const auto table = tables::document_of(read_text_file(path.string()), name);
    const auto method = table["method"].value<std::string>();
    const bool rehearsal = table["instrument"].is_table() && table["schedule"].is_array();
    if (!method && !rehearsal) return nullptr;
    return {{"name", name},
            {"method", method.value_or("")},
            {"title", table["title"].value_or(name)},
            {"instrument", table["instrument"]["model"].value_or(std::string())},
            {"rig", table["rig"]["kind"].value_or(std::string())},
            {"modified", modified_of(path)}};
  } catch (const std::exception&) {
    return nullptr;
  }
}

Json plans_of_folder(const fs::path& folder) {
  std::vector<Json> list;
  std::error_code failed;
  fs::recursive_directory_iterator place(folder, fs::directory_options::skip_permission_denied, failed);
  for (; place != fs::recursive_directory_iterator() && list.size() < most_plans; place.increment(failed)) {
    if (failed) break;
    const auto& path = place->path();
    const auto name = fs::relative(path, folder, failed).generic_string();
    if (is_hidden(path) || place.depth() > 3 || name == "jobs") place.disable_recursion_pending();
    if (path.extension() != ".toml" || place->is_symlink(failed) || !place->is_regular_file(failed) ||
        !is_plain_name(name) || place->file_size(failed) > longest_plan)
      continue;
    if (auto plan = listed_plan(name, path); !plan.is_null()) list.push_back(std::move(plan));
  }
  std::ranges::sort(list, {}, [](const Json& plan) { return plan["name"].get<std::string>(); });
  return Json(list);
}

/// Plans of the folder, those that travel inside the program, and the methods that need none.
HttpResponse plans(Context& context, const HttpRequest& request) {
  const Language language = language_asked(request);
  Json templates = Json::array(), methods = Json::array();
  for (const ReadyPlan& plan : ready_plans())
    templates.push_back({{"name", plan.name}, {"method", plan.method}, {"title", said_in(language, plan.title)}});
  for (const Method* method : method_catalogue())
    if (!method->needs_plan)
      methods.push_back({{"name", method->name},
                         {"summary", find_text(language, "summary", method->name).value_or(method->summary)}});
  return json_response(
      {{"plans", plans_of_folder(context.options.folder)}, {"templates", templates}, {"methods", methods}});
}

/// The text of a plan, with the tag by which save() knows whether somebody else changed it.
HttpResponse plan(Context& context, const HttpRequest& request) {
  if (const auto* name = find_query(request, "template")) {
    const ReadyPlan& ready = find_ready_plan(*name);
    return json_response({{"file", ""}, {"text", ready.text}, {"tag", ""}});
  }
  const auto name = required(request, "file");
  const auto path = existing(context, name);
  std::error_code failed;
  if (fs::file_size(path, failed) > longest_plan || failed)
    throw Error{Error::Kind::bad_input, say("'{}' is larger than a plan may be (1 MB)", name)};
  const auto text = read_text_file(path);
  return json_response({{"file", name}, {"text", text}, {"tag", sha256_of(text)}});
}

/// The outermost of the places of a problem, and those in it.
std::pair<Sentence, Sentence> outermost(const Sentence& place) {
  const bool nested = place.pattern == "{}: {}" && place.values.size() == 2 && !place.values[1].nested.empty();
  return nested ? std::pair{place.values[0].nested.front(), place.values[1].nested.front()}
                : std::pair{place, Sentence()};
}

/// A problem with the line of the plan where it is; 0: none. Its other members are those of every refusal.
Json placed_problem(const Context& context, Language language, Error::Kind kind, Problem problem,
                    const std::string& path) {
  const auto [place, inner] = outermost(problem.where.place);
  const bool here = problem.where.file == path && !place.values.empty() && place.values.front().text == path;
  const auto line = here ? problem.where.line : 0;
  if (here) problem.where.place = inner;
  problem = named_from(context.options.folder.string(), std::move(problem));
  Json json = Json::parse(problems_to_json(code_of(kind), {problem}, language)).front();
  json["line"] = line;
  return json;
}

/// What the form shows of a value: its text, how it is written, and its line.
Json json_of(const toml::node& node) {
  Json json{{"line", node.source().begin.line}};
  if (const auto* table = node.as_table()) {
    json["table"] = Json::object();
    for (const auto& [key, child] : *table) json["table"][std::string(key.str())] = json_of(child);
  } else if (const auto* array = node.as_array(); array && !array->empty() && array->get(0)->is_table()) {
    json["list"] = Json::array();
    for (const auto& child : *array) json["list"].push_back(json_of(child));
  } else {
    json["text"] = tables::text_of(node).value_or("");
    json["quoted"] = node.is_string();
  }
  return json;
}

/// Power-ups of the schedule, each with its segments: number in the text, label, begin and duration [s].
Json timeline_of(const Plan& plan) {
  Json runs = Json::array();
  double total = 0.0;
  for (const auto& segment : plan.schedule) {
    if (runs.empty() || runs.back()["run"] != segment.run)
      runs.push_back({{"run", segment.run}, {"duration", 0.0}, {"segments", Json::array()}});
    auto& run = runs.back();
    const double begin = run["duration"].get<double>();
    run["segments"].push_back({{"label", segment.label}, {"begin", begin}, {"duration", segment.duration}});
    run["duration"] = begin + segment.duration;
    total += segment.duration;
  }
  return {{"total", total}, {"runs", runs}};
}

/// The plan as it is written: what its form shows, all its problems, and its schedule where there is none.
HttpResponse look(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto text = text_in(body, "text");
  const auto path = place_of_plan(context, text_in(body, "file"));
  const Language language = language_asked(request);
  Json answer{{"problems", Json::array()}, {"document", nullptr}, {"schedule", nullptr}};
  try {
    const auto document = tables::document_of(text, path);
    answer["document"] = json_of(document)["table"];
    answer["schedule"] = timeline_of(plan_of_text(text, path));
  } catch (const Error& error) {
    for (const auto& problem : error.problems) {
      answer["problems"].push_back(placed_problem(context, language, error.kind, problem, path));
    }
  }
  return json_response(answer);
}

PlanPath path_in(const Json& change) {
  PlanPath path;
  if (change.contains("path") && change["path"].is_array())
    for (const auto& step : change["path"]) path.push_back(step.is_string() ? step.get<std::string>() : step.dump());
  return path;
}

/// A value of the form as TOML.
std::string toml_of(const Json& value) {
  if (value.is_string()) return toml_text(value.get<std::string>());
  if (value.is_boolean() || value.is_number()) return value.dump();
  const bool list = value.is_array();
  if (!list && !value.is_object()) throw Error{Error::Kind::bad_input, "a value is expected"};
  std::string text;
  for (const auto& [key, child] : value.items())
    text += (text.empty() ? "" : ", ") + (list ? "" : key + " = ") + toml_of(child);
  return (list ? "[" : "{") + text + (list ? "]" : "}");
}

/// The text with one change of the form.
HttpResponse edit(Context&, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto text = text_in(body, "text"), kind = text_in(body, "change");
  const auto file = text_in(body, "file").empty() ? "the plan" : text_in(body, "file");
  const auto path = path_in(body);
  const auto value = body.value("value", Json());
  const auto which = [&]() -> PlanList {
    const bool good = path.size() == 2 && !path[1].empty() && path[1].size() < 7 && is_digits(path[1]);
    if (!good) throw Error{Error::Kind::bad_input, "'path' must be a list and a number"};
    return {path[0], as_number<std::size_t>(path[1]).value_or(0)};
  };
  std::string changed;
  if (kind == "set")
    changed = with_value(text, file, path, toml_of(value));
  else if (kind == "remove")
    changed = without_value(text, file, path);
  else if (kind == "copy")
    changed = with_copy(text, file, which());
  else if (kind == "delete")
    changed = without_table(text, file, which());
  else if (kind == "swap")
    changed = with_next_before(text, file, which());
  else if (kind == "add" && path.size() == 1 && value.is_object()) {
    std::string lines;
    for (const auto& [key, one] : value.items()) lines += key + " = " + toml_of(one) + "\n";
    changed = with_table(text, file, path[0], lines);
  } else
    throw Error{Error::Kind::bad_input, say("there is no change '{}'", kind)};
  return json_response({{"text", changed}});
}

/// Writes a plan, unless the file is not the one that was read: `tag` is the hash of what was; empty: a new file.
HttpResponse save(Context& context, const HttpRequest& request) {
  static std::mutex one_at_a_time;
  const Json body = body_of(request);
  const auto file = text_in(body, "file"), text = text_in(body, "text"), tag = text_in(body, "tag");
  if (file.empty()) throw Error{Error::Kind::bad_input, "the name of the file is missing"};
  const auto path = place_of_plan(context, file);
  const std::lock_guard lock(one_at_a_time);
  std::error_code failed;
  const bool there = fs::exists(path, failed);
  if (there && tag.empty()) return problem_response(409, say("'{}' is there already; choose another name", file));
  if (there && sha256_of(read_text_file(path)) != tag)
    return problem_response(
        409, say("'{}' changed on the disk after it was opened here: save under another name, or open it again", file));
  if (!there && !tag.empty())
    return problem_response(409, say("'{}' is not there any more: save under another name", file));
  write_file_atomically(path, text);
  return json_response({{"file", file}, {"tag", sha256_of(text)}});
}

/// A plan of the folder rehearsed: simulated, identified and reported; its schedule improved; or what could go wrong in it.
HttpResponse plan_job(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto file = text_in(body, "file"), what = text_in(body, "what");
  const auto path = existing(context, file);
  const std::string language = text_in(body, "language") == "zh" ? "zh" : "en";
  Job job;
  job.title = file;
  job.kind = what;
  if (what == "rehearse")
    job.steps = {{"simulate", path, "-o", "{folder}/simulated.h5", "--quiet"},
                 {"identify", path, "{folder}/simulated.h5", "--quiet", "-o", "{folder}/result.json"},
                 {"report", "{folder}/result.json", "-o", "{folder}/report.html", "--language", language}};
  else if (what == "optimise")
    job.steps = {{"predict", path, "--optimise", "--quiet", "-o", "{folder}/optimised.toml"}};
  else if (what == "validate")
    job.steps = {{"validate", path, "--quiet", "-o", "{folder}/validation.json"},
                 {"report", "{folder}/validation.json", "-o", "{folder}/report.html", "--language", language}};
  else
    throw Error{Error::Kind::bad_input, "'what' is rehearse, optimise or validate"};
  return started(context, request, std::move(job));
}

}  // namespace

std::string place_of_plan(const Context& context, const std::string& name) {
  if (name.empty()) return (context.options.folder / "plan.toml").string();
  if (fs::path(name).extension() != ".toml")
    throw Error{Error::Kind::bad_input, say("'{}': the name must end in .toml", name)};
  const auto last = fs::path(name).filename().string(), above = fs::path(name).parent_path().string();
  require_file_name(last);
  const auto folder = above.empty() ? context.options.folder : inside(context.options.folder, above);
  std::error_code failed;
  if (fs::exists(folder / last, failed)) return inside(context.options.folder, name).string();
  if (!fs::is_directory(folder, failed))
    throw Error{Error::Kind::bad_input, say("'{}': there is no such folder", name)};
  return (folder / last).string();
}

std::vector<Route> plan_routes() {
  constexpr std::uint64_t one_plan = 2 * longest_plan;
  return {{"GET", "/api/plans", plans},
          {"GET", "/api/plan", plan},
          {.method = "POST", .path = "/api/plan/look", .answer = look, .body_limit = one_plan, .role = Right::read},
          {.method = "POST", .path = "/api/plan/edit", .answer = edit, .body_limit = one_plan, .role = Right::read},
          {.method = "POST", .path = "/api/plan/save", .answer = save, .body_limit = one_plan},
          {.method = "POST", .path = "/api/jobs/plan", .answer = plan_job, .body_limit = 1 << 16}};
}

}  // namespace tumble::routes
