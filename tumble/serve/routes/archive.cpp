#include "tumble/serve/routes/archive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "tumble/archive/archive_json.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/notes.hpp"
#include "tumble/archive/signatures.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/report/report.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::routes {

namespace fs = std::filesystem;

Archive archive_of(const Context& context) {
  if (context.options.archive.empty())
    throw Error{
        Error::Kind::bad_input,
        "this workbench has no archive: start it by tumble serve --archive ARCHIVE, which `tumble archive init` "
        "makes"};
  return Archive(context.options.archive, utc_now(context));
}

std::string utc_now(const Context& context) {
  constexpr double nanoseconds = 1e9;
  return iso_second(static_cast<std::int64_t>(context.options.clock() * nanoseconds));
}

std::string person_of(const Context& context, const HttpRequest& request) {
  const auto session = context.guard.known_session_of(request);
  return session && !session->user.empty() ? session->user : context.options.person;
}

HttpResponse sandboxed(const std::string& type, std::string body) {
  HttpResponse response;
  response.type = type;
  response.body = std::move(body);
  response.headers.emplace_back(
      "Content-Security-Policy",
      "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; "
      "frame-ancestors 'self'");
  return response;
}

namespace {

constexpr double day = 24.0 * hour;  ///< [s]
constexpr const char* end_of_time = "9999-12-31";

/// The day so many seconds from now, UTC.
std::string day_in(const Context& context, double seconds) {
  constexpr double nanoseconds = 1e9;
  return iso_day(static_cast<std::int64_t>((context.options.clock() + seconds) * nanoseconds));
}

HttpResponse units(Context& context, const HttpRequest& request) {
  const Archive archive = archive_of(context);
  std::map<std::pair<std::string, std::string>, std::string> due;
  for (const auto& one : due_units(archive, end_of_time)) due[{one.unit.model, one.unit.serial}] = one.due;
  const std::string today = day_in(context, 0.0);
  Json list = Json::parse(units_json(archived_units(archive, optional(request, "model"))));
  for (auto& unit : list) {
    const auto found = due.find({unit["model"], unit["serial"]});
    unit["due"] = found == due.end() ? "" : found->second;
    unit["overdue"] = found != due.end() && found->second < today;
  }
  return json_response({{"units", list}, {"today", today}});
}

HttpResponse unit(Context& context, const HttpRequest& request) {
  const Archive archive = archive_of(context);
  const UnitName name = find_unit(archive, required(request, "unit"));
  Json record = Json::parse(record_json(unit_record(archive, name)));
  record["parameters"] = charted_parameters(archive, name.model, name);
  return json_response(record);
}

HttpResponse model(Context& context, const HttpRequest& request) {
  const Archive archive = archive_of(context);
  return json_response({{"parameters", charted_parameters(archive, required(request, "model"))}});
}

HttpResponse due(Context& context, const HttpRequest& request) {
  const double within = find_query(request, "days") ? required_number(request, "days") : 60.0;
  if (!(within >= 0.0 && within <= 36525.0)) throw Error{Error::Kind::bad_input, "'days' is a number from 0 to 36525"};
  const Archive archive = archive_of(context);
  const std::string until = day_in(context, within * day), today = day_in(context, 0.0);
  Json answer = Json::parse(due_json(due_calibrations(archive, until), due_units(archive, until)));
  for (const char* const kind : {"equipment", "units"})
    for (auto& one : answer[kind]) one["overdue"] = one["due"].get<std::string>() < today;
  answer["today"] = today;
  answer["until"] = until;
  return json_response(answer);
}

HttpResponse verify(Context& context, const HttpRequest& request) {
  archive_of(context);
  Job job;
  job.kind = "verify";
  job.title = context.options.archive.find("://") == std::string::npos
                  ? fs::path(context.options.archive).filename().string()
                  : "postgresql";
  job.steps = {{"archive", "verify", "--quiet", "-o", "{folder}/verify.txt"}};
  return started(context, request, std::move(job));
}

/// The file of this SHA-256 that is called so: beside the result, in the folder, among the uploads, or where it was.
/// Empty where none is in the folder.
std::string input_in_folder(const Context& context, const fs::path& result, const std::string& file,
                            const std::string& sha256) {
  const auto& root = context.options.folder;
  const auto name = fs::path(file).filename();
  for (const fs::path& place : {result.parent_path() / name, root / name, root / "uploads" / name, fs::path(file)}) {
    const auto relative = place.lexically_relative(root).generic_string();
    std::error_code failed;
    if (relative.empty() || relative.starts_with("..") || !fs::is_regular_file(place, failed)) continue;
    try {
      const auto path = inside(root, relative).string();
      if (sha256_of_file(path) == sha256) return path;
    } catch (const Error&) {
      continue;  // its name leads elsewhere
    }
  }
  return "";
}

/// Files of the folder that a result was made from, with the bytes that they had.
std::vector<FileDeposit> inputs_in_folder(const Context& context, const fs::path& result, const Estimate& estimate) {
  std::vector<FileDeposit> files;
  const auto add = [&](const std::string& file, const std::string& sha256) {
    const auto path = input_in_folder(context, result, file, sha256);
    if (!path.empty()) files.push_back({.path = path, .name = fs::path(path).filename().string()});
  };
  for (const auto& input : estimate.provenance.inputs) add(input.file, input.sha256);
  for (const auto& plan : estimate.provenance.plans) add(plan.file, plan.sha256);
  return files;
}

/// A result of the folder into the archive, with those of its files that are here.
HttpResponse put(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  const std::string file = text_in(body, "result"), path = existing(context, file), text = read_text_file(path);
  const Estimate estimate = estimate_from_json(text, file);
  Archive archive = archive_of(context);
  Deposit deposit;
  deposit.results.push_back({.json = text, .file = file});
  if (const auto replaced = text_in(body, "replaces"); !replaced.empty())
    deposit.results.front().corrects = find_result(archive, replaced);
  deposit.files = inputs_in_folder(context, path, estimate);
  const auto done = put_in(archive, deposit, {person_of(context, request), utc_now(context), text_in(body, "reason")});
  context.feed.publish("recordings", "{}");
  return json_response({{"results", done.results},
                        {"files", done.files},
                        {"known", done.known},
                        {"sha256", done.result_ids.empty() ? "" : done.result_ids.front()},
                        {"model", estimate.instrument_model},
                        {"serial", estimate.instrument_serial}},
                       201);
}

/// A signature needs the password again: an open page alone signs nothing.
HttpResponse sign_thing(Context& context, const HttpRequest& request) {
  const Json body = body_of(request);
  if (!context.guard.users)
    return problem_response(
        409, "signatures are of people: start the workbench by tumble serve --users FILE, so that each signs in");
  const auto session = context.guard.session_of(request);
  Archive archive = archive_of(context);
  const auto check = context.guard.users->check(session->user, text_in(body, "password"));
  if (check.state != PasswordCheck::State::right) return password_refusal(check);
  const auto digits = text_in(body, "sha256");
  if (digits.size() != 64) throw Error{Error::Kind::bad_input, "'sha256' must be that of a whole file: 64 digits"};
  sign(archive, digits, text_in(body, "meaning"), {session->user, utc_now(context), text_in(body, "reason")});
  context.feed.publish("recordings", "{}");
  return json_response({{"signed", digits}, {"wrong_before", check.before}}, 201);
}

}  // namespace

std::vector<Route> archive_routes() {
  constexpr std::uint64_t small = 1 << 14;
  std::vector<Route> all{{"GET", "/api/archive/units", units},
                         {"GET", "/api/archive/unit", unit},
                         {"GET", "/api/archive/model", model},
                         {"GET", "/api/archive/due", due},
                         {.method = "POST", .path = "/api/archive/verify", .answer = verify, .body_limit = small},
                         {.method = "POST", .path = "/api/archive/results", .answer = put, .body_limit = small},
                         {.method = "POST",
                          .path = "/api/archive/sign",
                          .answer = sign_thing,
                          .body_limit = small,
                          .role = Right::approve,
                          .lane = Lane::sign_in}};
  for (const auto& some : {archive_chart_routes(), archive_certificate_routes()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace tumble::routes
