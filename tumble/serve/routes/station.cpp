// The station: what is there, what would be refused, and runs that are begun.
#include "tumble/serve/routes/station.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <thread>

#include "tumble/desk/run_desk.hpp"
#include "tumble/desk/run_texts.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/language/said.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/jobs/process.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/station/carry_out.hpp"
#include "tumble/station/run_folder.hpp"
#include "tumble/tasks/stopping_rule.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::routes {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_stations = 500;

/// "2026-11-24" and "20261124-093005" of now.
std::string date_text(const Context& context, const char* form) {
  const auto now = static_cast<std::time_t>(context.options.clock ? context.options.clock() : 0.0);
  std::tm parts{};
  localtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, form, &parts);
  return text;
}

/// A walk through the folder that skips what is hidden, jobs, and what lies too deep.
template <class Visit>
void walk_folder(const fs::path& root, int deepest, Visit visit) {
  std::error_code failed;
  fs::recursive_directory_iterator place(root, fs::directory_options::skip_permission_denied, failed);
  for (; !failed && place != fs::recursive_directory_iterator(); place.increment(failed)) {
    const auto name = fs::relative(place->path(), root, failed).generic_string();
    if (is_hidden(place->path()) || place.depth() >= deepest || name == "jobs") place.disable_recursion_pending();
    if (is_plain_name(name) && !place->is_symlink(failed)) visit(*place, name);
  }
}

/// A file of a station has the table [station] or a device; whether it is sound is another question.
bool looks_like_station(const fs::path& path) {
  try {
    const auto text = read_text_file(path.string());
    return text.find("[[device]]") != std::string::npos || text.find("[station]") != std::string::npos;
  } catch (const Error&) {
    return false;
  }
}

/// Names in messages are those of the folder.
Problems named_from_folder(const fs::path& root, Problems problems) {
  for (auto& problem : problems) problem = named_from(root.string(), problem);
  return problems;
}

Json station_json(const fs::path& root, const std::string& name) {
  Json json{{"file", name}};
  try {
    const Station station = load_station((root / name).string());
    Json slots = Json::array(), devices = Json::array();
    for (const auto& instrument : station.instruments)
      slots.push_back({{"slot", instrument.slot}, {"frames", instrument.frames}, {"link", instrument.link}});
    for (const auto& device : station.devices)
      devices.push_back({{"name", device.name}, {"controller", device.controller}, {"link", device.link}});
    json.update({{"name", station.name}, {"slots", slots}, {"devices", devices}});
  } catch (const Error& error) {
    json["problems"] = texts_of(named_from_folder(root, error.problems));
  }
  return json;
}

/// Runs of the folder, the newest first.
Json runs_json(Context& context) {
  std::vector<std::pair<fs::file_time_type, std::string>> runs;
  std::error_code failed;
  walk_folder(context.options.folder, 2, [&](const fs::directory_entry& entry, const std::string& name) {
    const auto store = entry.path() / live_store_name;
    if (entry.is_directory(failed) && fs::exists(entry.path() / "plan.toml", failed) && fs::exists(store, failed))
      runs.emplace_back(fs::last_write_time(entry.path() / "plan.toml", failed), name);
  });
  std::ranges::sort(runs, std::greater<>{});
  if (runs.size() > most_stations) runs.resize(most_stations);
  Json list = Json::array();
  for (const auto& [when, name] : runs) {
    const auto begun = std::chrono::duration<double>(fs::file_time_type::clock::to_sys(when).time_since_epoch());
    list.push_back({{"run", name},
                    {"begun", begun.count()},
                    {"alive", process_at_desk((context.options.folder / name).string()).has_value()}});
  }
  return list;
}

HttpResponse list_stations(Context& context, const HttpRequest& request) {
  Json stations = Json::array();
  std::error_code failed;
  walk_folder(context.options.folder, 3, [&](const fs::directory_entry& entry, const std::string& name) {
    if (stations.size() < most_stations && entry.path().extension() == ".toml" && entry.is_regular_file(failed) &&
        !fs::exists(entry.path().parent_path() / live_store_name, failed) && entry.file_size(failed) < 1'000'000 &&
        looks_like_station(entry.path()))
      stations.push_back(station_json(context.options.folder, name));
  });
  return said_response(request, {{"stations", stations}, {"runs", runs_json(context)}});
}

/// On the devices of the station, on a virtual rig behind its links, or as fast as it goes on a virtual rig.
enum class RunMode { run, with_virtual_rig, rehearse };
constexpr std::array<std::string_view, 3> run_mode_words{"run", "virtual", "rehearse"};

/// What somebody wants to begin.
struct WantedRun {
  RunMode mode = RunMode::run;
  std::string plan, station, who, accept_expired, speed;  ///< names in the folder
  std::map<std::string, std::string> units;
};

WantedRun wanted_run_of(const Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto mode = std::ranges::find(run_mode_words, plain_text_in(body, "mode"));
  WantedRun wanted{static_cast<RunMode>(mode - run_mode_words.begin()),
                   plain_text_in(body, "plan"),
                   plain_text_in(body, "station"),
                   who_of(context, request, body),
                   plain_text_in(body, "accept_expired"),
                   plain_text_in(body, "speed")};
  if (mode == run_mode_words.end()) throw Error{Error::Kind::bad_input, "'mode' must be run, virtual or rehearse"};
  if (body.contains("units"))
    for (const auto& [slot, serial] : body["units"].items())
      if (serial.is_string() && !serial.get<std::string>().empty())
        wanted.units[slot] = plain_text_in(body["units"], slot.c_str());
  return wanted;
}

template <class Work>
void collect_problems(Problems& problems, Work work) {
  try {
    work();
  } catch (const Error& error) {
    problems.insert(problems.end(), error.problems.begin(), error.problems.end());
  }
}

/// The segments of a run with their rules, and how long it takes [s]; without a plan there is none.
Json course_of_run(const std::optional<Plan>& plan) {
  Json timeline = Json::array();
  double total = 0.0;
  if (plan) {
    const auto rules = stopping_rules(*plan);
    for (const Segment& segment : plan->schedule) {
      const auto rule = rules.find(segment.label);
      timeline.push_back({{"label", segment.label},
                          {"begin_text", hours_text(total)},
                          {"duration", segment.duration},
                          {"duration_text", hours_text(segment.duration)},
                          {"rule", rule == rules.end() ? "" : rule->second.text}});
      total += segment.duration;
    }
  }
  return {{"timeline", timeline}, {"total", total}, {"total_text", hours_text(total)}};
}

/// All reasons why it cannot be begun, and what it would do.
std::pair<Problems, Json> checked_run(const Context& context, const WantedRun& wanted) {
  Problems problems;
  std::optional<Plan> plan;
  std::optional<Station> station;
  collect_problems(problems, [&] { plan = load_plan(existing(context, wanted.plan), {}); });
  if (!wanted.station.empty() || wanted.mode != RunMode::rehearse)
    collect_problems(problems, [&] {
      station = load_station(existing(context, wanted.station));
      parts_of(*station);
    });
  if (wanted.mode != RunMode::rehearse && wanted.who.empty())
    problems.emplace_back("the operator is missing: who carries it out");
  if (plan && station) {
    const bool rehearsed = wanted.mode == RunMode::rehearse;
    auto units = wanted.units;
    if (rehearsed)
      for (const auto& instrument : station->instruments)
        units.try_emplace(instrument.slot, "rehearsed " + instrument.slot);
    const StationRequest request{units, date_text(context, "%Y-%m-%d"), rehearsed, wanted.accept_expired};
    collect_problems(problems, [&] {
      const auto found = check_station(*plan, *station, request);
      problems.insert(problems.end(), found.begin(), found.end());
    });
  }
  return {named_from_folder(context.options.folder, problems), course_of_run(plan)};
}

HttpResponse dry_run_at_station(Context& context, const HttpRequest& request) {
  auto [problems, json] = checked_run(context, wanted_run_of(context, request));
  json["problems"] = in_language(language_asked(request), problems);
  return said_response(request, json);
}

/// A folder for a run that nothing has yet: "runs/north-20261124-093005".
std::string new_run(const Context& context, const std::string& plan) {
  const fs::path folder = context.options.folder / "runs";
  fs::create_directories(folder);
  inside(context.options.folder, "runs");
  std::string stem = fs::path(plan).stem().string();
  std::ranges::replace(stem, '.', '-');
  const std::string base = fmt::format("{}-{}", stem, date_text(context, "%Y%m%d-%H%M%S"));
  std::string name = base;
  for (int n = 2; fs::exists(folder / name) || fs::exists(folder / (name + ".log")); ++n)
    name = fmt::format("{}-{}", base, n);
  return "runs/" + name;
}

/// Takes what a process hands on, for which it waits 30 ms. Returned: whether the process has ended.
bool take_handed_on(int descriptor, std::string& handed_on) {
  pollfd ready{descriptor, POLLIN, 0};
  if (poll(&ready, 1, 30) <= 0) return false;
  char bytes[4096];
  const auto count = read(descriptor, bytes, sizeof bytes);
  if (count > 0) handed_on.append(bytes, static_cast<std::size_t>(count));
  return count == 0;
}

/// What the program has said against it; empty: its run goes on, or has ended by itself. A run that is carried on has a
/// store from before, which shows nothing.
Problems begun_problems(const Context& context, const std::string& run, const std::vector<std::string>& arguments,
                        bool again = false) {
  using namespace std::chrono_literals;
  const std::string log = (context.options.folder / (run + ".log")).string();
  int alive = -1;
  try {
    alive = jobs::start_detached(context.options.program, arguments, log);
  } catch (const Error& error) {
    return named_from_folder(context.options.folder, not_begun(error, false).problems);
  }
  if (alive < 0) return {Problem("no process can be started")};
  const auto until = std::chrono::steady_clock::now() + 30s;
  bool ended = false, open = false;
  std::string handed_on;
  while (!ended && !open && std::chrono::steady_clock::now() < until) {
    ended = take_handed_on(alive, handed_on);
    open = process_at_desk((context.options.folder / run).string()).has_value();
  }
  close(alive);
  if (open) return {};
  if (ended && fs::exists(context.options.folder / run / live_store_name) && !(again && !handed_on.empty())) return {};
  if (!ended) return {say("the run has not begun within 30 s; its messages are in {}", Name{run + ".log"})};
  jobs::Outcome outcome{.status = -1, .messages = read_text_file(log), .problems = {}};
  outcome.messages.erase(0, outcome.messages.find('\n') + 1);  // the verb
  jobs::take_problems(handed_on, outcome.problems);
  return jobs::problems_of(outcome, context.options.folder.string()).problems;
}

HttpResponse start_run(Context& context, const HttpRequest& request) {
  const WantedRun wanted = wanted_run_of(context, request);
  if (auto [problems, timeline] = checked_run(context, wanted); !problems.empty())
    return problem_response(422, problems);
  const std::string run = new_run(context, wanted.plan);
  const std::string folder = (context.options.folder / run).string();
  std::vector<std::string> arguments;
  if (wanted.mode == RunMode::rehearse) {
    arguments = {"rehearse", existing(context, wanted.plan), "-o", folder + ".h5"};
    if (!wanted.station.empty()) arguments.push_back("--station=" + existing(context, wanted.station));
  } else {
    arguments = {"run",  existing(context, wanted.plan), "--station=" + existing(context, wanted.station), "-o",
                 folder, "--operator=" + wanted.who};
    for (const auto& [slot, serial] : wanted.units) arguments.push_back("--unit=" + slot + "=" + serial);
    if (wanted.mode == RunMode::with_virtual_rig) arguments.emplace_back("--virtual-rig");
    if (!wanted.accept_expired.empty()) arguments.push_back("--accept-expired=" + wanted.accept_expired);
  }
  if (!wanted.speed.empty() && wanted.mode != RunMode::run) arguments.push_back("--speed=" + wanted.speed);
  if (auto problems = begun_problems(context, run, arguments); !problems.empty())
    return problem_response(422, problems);
  return json_response({{"run", run}}, 201);
}

HttpResponse resume_run(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const auto run = plain_text_in(body, "run"), who = who_of(context, request, body),
             speed = plain_text_in(body, "speed");
  const auto folder = existing(context, run);
  if (who.empty()) throw Error{Error::Kind::bad_input, "the operator is missing: who carries it out"};
  if (process_at_desk(folder)) throw Error{Error::Kind::bad_input, "the run goes on"};
  std::vector<std::string> arguments{"resume", folder, "--operator=" + who};
  if (!speed.empty()) arguments.push_back("--speed=" + speed);
  if (auto problems = begun_problems(context, run, arguments, true); !problems.empty())
    return problem_response(422, problems);
  return json_response({{"run", run}}, 201);
}

/// Speaks to all devices and moves none, as a job.
HttpResponse check_devices(Context& context, const HttpRequest& request) {
  const auto name = plain_text_in(body_of(request), "station");
  Job job;
  job.kind = "check";
  job.title = name;
  job.steps = {{"station", "check", existing(context, name), "-o", "{folder}/check.json"}};
  return started(context, request, std::move(job));
}

}  // namespace

std::string plain_text_in(const Json& body, const char* name) {
  auto text = text_in(body, name);
  if (text.size() <= 1000 && is_plain_name(text)) return text;
  throw Error{Error::Kind::bad_input, say("'{}' is too long, or has characters that cannot be shown", name)};
}

std::string who_of(const Context& context, const HttpRequest& request, const Json& body) {
  const auto session = context.guard.users ? context.guard.known_session_of(request) : std::nullopt;
  return session ? session->user : plain_text_in(body, "who");
}

std::vector<Route> station_routes() {
  constexpr std::uint64_t small = 1 << 16;
  return {
      {.method = "GET", .path = "/api/station", .answer = list_stations, .lane = Lane::looks},
      {.method = "POST", .path = "/api/station/check", .answer = check_devices, .body_limit = small},
      {.method = "POST", .path = "/api/station/dry-run", .answer = dry_run_at_station, .body_limit = small},
      {.method = "POST", .path = "/api/station/start", .answer = start_run, .body_limit = small, .lane = Lane::begins},
      {.method = "POST",
       .path = "/api/station/resume",
       .answer = resume_run,
       .body_limit = small,
       .lane = Lane::begins}};
}

}  // namespace tumble::routes
