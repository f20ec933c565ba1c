#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>

#include "tumble/formats/format.hpp"
#include "tumble/language/said.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/numbers.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/units/error.hpp"

namespace tumble::routes {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_files = 5000;
constexpr int deepest = 4;
constexpr std::uintmax_t prepared_unasked = 64'000'000;  ///< bytes of a file that is looked at before anybody opens it
constexpr std::size_t most_unasked = 200;

bool has_extension_of_recording(const fs::path& path) {
  const auto name = path.filename().string();
  std::string lower = name;
  std::ranges::transform(lower, lower.begin(), [](unsigned char letter) { return std::tolower(letter); });
  for (const Format* format : format_catalogue())
    for (const auto& extension : format->extensions)
      if (lower.size() > extension.size() && lower.ends_with(extension)) return true;
  return false;
}

bool is_recording_folder(const fs::path& path) {
  for (const Format* format : format_catalogue()) try {
      if (format->folders && format->recognises(path.string())) return true;
    } catch (const Error&) {
    }
  return false;
}

double seconds_of(fs::file_time_type time) {
  const auto system = std::chrono::file_clock::to_sys(time);
  return std::chrono::duration<double>(system.time_since_epoch()).count();
}

/// Names and sizes of what may be recordings, the newest first.
struct Listed {
  std::string name;
  std::uintmax_t bytes = 0;
  double modified = 0.0;  ///< [s] since 1970-01-01
};

struct Listing {
  std::vector<Listed> files;
  std::size_t unprintable = 0;
  bool cut = false;
};

Listing list_folder(const Context& context) {
  Listing listing;
  std::error_code failed;
  fs::recursive_directory_iterator place(context.options.folder, fs::directory_options::skip_permission_denied, failed);
  for (; place != fs::recursive_directory_iterator(); place.increment(failed)) {
    if (failed) break;
    const auto& path = place->path();
    const auto name = fs::relative(path, context.options.folder, failed).generic_string();
    const bool folder = place->is_directory(failed), link = place->is_symlink(failed);
    if (folder && (link || is_hidden(path) || place.depth() + 1 >= deepest || name == "jobs"))
      place.disable_recursion_pending();
    if (is_hidden(path)) continue;
    if (!is_plain_name(name)) {
      ++listing.unprintable;
      continue;
    }
    const bool recording_folder = folder && !link && is_recording_folder(path);
    if (recording_folder) place.disable_recursion_pending();
    if (!recording_folder && (!place->is_regular_file(failed) || (!has_extension_of_recording(path) && !is_live(path))))
      continue;
    if (link) try {
        inside(context.options.folder, name);
      } catch (const Error&) {
        continue;
      }
    if (listing.files.size() == most_files) {
      listing.cut = true;
      break;
    }
    Listed file{name, recording_folder ? 0 : place->file_size(failed), 0.0};
    if (const auto time = place->last_write_time(failed); !failed) file.modified = seconds_of(time);
    listing.files.push_back(std::move(file));
  }
  std::ranges::sort(listing.files, [](const Listed& a, const Listed& b) {
    return a.modified != b.modified ? a.modified > b.modified : a.name < b.name;
  });
  return listing;
}

double duration_of(const Pyramid& pyramid) {
  double first = std::numeric_limits<double>::infinity(), last = -first;
  for (const auto& channel : pyramid.channels())
    if (channel.samples > 0) first = std::min(first, channel.first), last = std::max(last, channel.last);
  return last > first ? last - first : 0.0;
}

std::size_t serious_findings(const std::string& inspection) {
  const Json json = Json::parse(inspection, nullptr, false);
  std::size_t count = 0;
  if (!json.is_object() || !json.contains("findings")) return 0;
  for (const auto& finding : json["findings"]) count += finding.value("severity", "") != "info";
  return count;
}

void describe(const RecordingState& state, Json& entry) {
  if (!state.problems.empty()) entry["problems"] = texts_of(state.problems);
  if (!state.job.empty()) entry["job"] = state.job;
  if (!state.prepared) return;
  const Pyramid& pyramid = *state.prepared->pyramid;
  Json channels = Json::array();
  std::size_t samples = 0;
  for (const auto& channel : pyramid.channels()) {
    channels.push_back(channel.name);
    samples = std::max(samples, channel.samples);
  }
  entry["instrument"] = pyramid.header().instrument;
  entry["channels"] = channels;
  entry["samples"] = samples;
  entry["duration"] = duration_of(pyramid);
  if (const auto& live = state.prepared->live) entry["live"] = {{"going_on", live->going_on}};
  if (!state.prepared->inspection.empty()) entry["warnings"] = serious_findings(state.prepared->inspection);
}

HttpResponse list_recordings(Context& context, const HttpRequest& request) {
  const Listing listing = list_folder(context);
  Json files = Json::array();
  const std::string owner = user_of(context, request);
  std::size_t asked = 0;
  for (const Listed& file : listing.files) {
    Json entry{{"name", file.name}, {"bytes", file.bytes}, {"modified", file.modified}};
    try {
      const bool start = file.bytes <= prepared_unasked && asked < most_unasked;
      const auto state = context.recordings.find((context.options.folder / file.name).string(), {}, start, owner);
      asked += !state.job.empty();
      describe(state, entry);
    } catch (const Error& error) {
      entry["problems"] = texts_of(error.problems);
    }
    files.push_back(std::move(entry));
  }
  return said_response(request, {{"recordings", files}, {"unprintable", listing.unprintable}, {"cut", listing.cut}});
}

Json json_of(const PyramidChannel& channel) {
  const double rate = channel.samples > 1 && channel.last > channel.first
                          ? static_cast<double>(channel.samples - 1) / (channel.last - channel.first)
                          : 0.0;
  return {{"name", channel.name},        {"kind", name(channel.kind)},
          {"unit", channel.unit.text()}, {"units", units_like(channel.unit)},
          {"samples", channel.samples},  {"first", channel.first},
          {"last", channel.last},        {"rate", rate},
          {"stamped", channel.stamped}};
}

/// A segment ends where the next begins, the last with the data.
Json marks_of(const Pyramid& pyramid, double last) {
  Json marks = Json::array();
  const auto& all = pyramid.header().marks;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double end = std::min(all[i].end, i + 1 < all.size() ? all[i + 1].begin : last);
    marks.push_back({{"label", all[i].label}, {"begin", all[i].begin}, {"end", end}, {"run", all[i].run}});
  }
  return marks;
}

HttpResponse one_recording(Context& context, const HttpRequest& request) {
  const auto file = required(request, "file");
  const auto path = existing(context, file);
  const auto state = context.recordings.find(path, sets_of(all_of(request, "set")), true, user_of(context, request));
  if (!state.prepared && !state.problems.empty()) return problem_response(422, state.problems);
  Json answer{{"name", file}, {"job", state.job}};
  if (!state.prepared) return json_response(answer, 202);
  const Pyramid& pyramid = *state.prepared->pyramid;
  double first = std::numeric_limits<double>::infinity(), last = -first;
  Json channels = Json::array();
  for (const auto& channel : pyramid.channels()) {
    channels.push_back(json_of(channel));
    if (channel.samples > 0) first = std::min(first, channel.first), last = std::max(last, channel.last);
  }
  answer["tag"] = state.prepared->tag;
  answer["sha256"] = state.prepared->checksum;
  answer["instrument"] = pyramid.header().instrument;
  answer["first"] = first <= last ? Json(first) : Json(0.0);
  answer["last"] = first <= last ? Json(last) : Json(0.0);
  answer["channels"] = channels;
  answer["marks"] = marks_of(pyramid, last);
  answer["meta"] = pyramid.header().meta;
  if (const auto& live = state.prepared->live) {
    const fs::path target = fs::path(file).parent_path() / (live->target.empty() ? "recording.h5" : live->target);
    answer["live"] = {
        {"going_on", live->going_on}, {"behind", live->behind}, {"target", target.lexically_normal().generic_string()}};
  }
  const Json inspection = Json::parse(state.prepared->inspection, nullptr, false);
  answer["findings"] = inspection.is_object()
                           ? findings_in(language_asked(request), inspection.value("findings", Json::array()))
                           : Json();
  if (!state.problems.empty()) answer["problems"] = in_language(language_asked(request), state.problems);
  return json_response(answer);
}

/// "data.csv", or "data-2.csv" where that is taken.
fs::path place_for(const fs::path& folder, const std::string& name, const std::string& temporary) {
  const fs::path wanted(name);
  std::error_code failed;
  for (int number = 1; number < 1000; ++number) {
    const fs::path place =
        folder /
        (number == 1 ? name : fmt::format("{}-{}{}", wanted.stem().string(), number, wanted.extension().string()));
    fs::create_hard_link(temporary, place, failed);
    if (!failed) return place;
    if (failed != std::errc::file_exists)
      throw Error{Error::Kind::bad_file,
                  say("cannot write '{}': {}", place.filename().string(), system_reason(failed))};
  }
  throw Error{Error::Kind::bad_input, say("'{}': there are many files of that name", name)};
}

HttpResponse upload(Context& context, const HttpRequest& request) {
  const auto name = required(request, "name");
  require_file_name(name);
  if (!request.file || request.body_bytes == 0) throw Error{Error::Kind::bad_input, say("'{}' is empty", name)};
  const auto place = place_for(context.options.folder / "uploads", name, request.file->path());
  const auto file = "uploads/" + place.filename().string();
  context.feed.publish("recordings", "{}");
  return json_response({{"name", file}, {"bytes", request.body_bytes}}, 201);
}

}  // namespace

std::vector<Route> recording_routes() {
  return {{"GET", "/api/recordings", list_recordings},
          {"GET", "/api/recording", one_recording},
          {.method = "POST", .path = "/api/uploads", .answer = upload, .body_to_file = true}};
}

}  // namespace tumble::routes
