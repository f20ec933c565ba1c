#include "tumble/tasks/recompute.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/version.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Where the files of a result lie again: names that lead upwards stay within the scratch folder.
struct Workplace {
  std::string scratch, base;  ///< base: folder of the plan
  std::string path_of(const std::string& name) const {
    return fs::path(name).is_absolute() ? scratch + "/root" + fs::path(name).lexically_normal().string()
                                        : (fs::path(base) / name).lexically_normal().string();
  }
};

Workplace workplace_for(const Provenance& provenance, const std::string& scratch) {
  std::size_t most = 0;
  const auto count = [&](const std::string& name) {
    const fs::path path(name);
    most = std::max(most, static_cast<std::size_t>(std::ranges::count(path, fs::path(".."))));
  };
  for (const auto& input : provenance.inputs) count(input.file);
  for (const auto& plan : provenance.plans) count(plan.file);
  if (const auto prior = provenance.settings.find("prior"); prior != provenance.settings.end()) count(prior->second);
  fs::path base = scratch;
  for (std::size_t i = 0; i <= most; ++i) base /= "d";
  return {scratch, base.string()};
}

/// Puts plans and recordings where they were. Throws with all that are missing.
void lay_out(const Archive& archive, const Provenance& provenance, const Workplace& place) {
  Problems missing;
  const auto put = [&](const std::string& name, const std::string& sha256) {
    const std::string path = place.path_of(name);
    fs::create_directories(fs::path(path).parent_path());
    if (find_file(archive, sha256))
      write_stored(archive, sha256, path);
    else
      missing.push_back(say("'{}' ({}) is not in the archive: put it in with `tumble archive ingest`", name,
                            Name{first_digits(sha256)}));
  };
  for (const auto& plan : provenance.plans) {
    if (!plan.text) {
      put(plan.file, plan.sha256);
      continue;
    }
    fs::create_directories(fs::path(place.path_of(plan.file)).parent_path());
    write_file_atomically(place.path_of(plan.file), *plan.text);
  }
  for (const auto& input : provenance.inputs)
    if (input.sha256.empty())
      missing.push_back(say("the result does not say the checksum of '{}'", input.file));
    else
      put(input.file, input.sha256);
  if (!missing.empty()) throw Error(Error::Kind::bad_input, missing);
}

Estimate made_again(const Estimate& archived, const Workplace& place, const Progress& progress) {
  const Provenance& provenance = archived.provenance;
  const auto calibration = provenance.settings.find("calibration");
  Sets sets;
  for (const auto& [key, value] : provenance.command_line) {
    const auto setting = provenance.settings.find(key);
    const bool file = key == "calibration" || (key == "prior" && value != "archive");
    sets.emplace_back(key, file && setting != provenance.settings.end() ? place.path_of(setting->second) : value);
  }
  Plan plan = provenance.plans.empty() ? plan_for_method(archived.method, sets)
                                       : load_plan(place.path_of(provenance.plans.front().file), sets);
  if (archived.prior) plan.prior.population = archived.prior->population;  // the result holds its whole prior
  std::vector<std::string> recordings;
  for (const auto& input : provenance.inputs)
    if (calibration == provenance.settings.end() || input.file != calibration->second)
      recordings.push_back(place.path_of(input.file));
  const auto named = std::min(plan.recordings.size(), recordings.size());
  recordings.erase(recordings.begin(), recordings.begin() + static_cast<std::ptrdiff_t>(named));
  constexpr auto whole = std::numeric_limits<std::uintmax_t>::max();
  Estimate estimate = identify(plan, recordings, provenance.memory.value_or(whole), progress);
  estimate.provenance.command_line = provenance.command_line;
  return estimate;
}

void replace_all(std::string& text, const std::string& what, const std::string& by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
}

/// The text as it would be, had the files lain where the names of the archived result say.
std::string in_words_of(std::string text, const Workplace& place) {
  replace_all(text, place.base + "/", "");
  replace_all(text, place.scratch + "/root", "");
  return text;
}

/// A file of the result: where it lies in the scratch folder, and its name without folders.
struct KnownFile {
  std::string path, name;
};

std::vector<KnownFile> known_files(const Provenance& provenance, const Workplace& place) {
  std::vector<KnownFile> files;
  const auto add = [&](const std::string& name) {
    files.push_back({place.path_of(name), fs::path(name).filename().string()});
  };
  for (const auto& input : provenance.inputs) add(input.file);
  for (const auto& plan : provenance.plans) add(plan.file);
  std::ranges::sort(files, std::greater(), [](const KnownFile& file) { return file.path.size(); });
  return files;
}

/// Whether a text is that of now, with any folder before the names of the files: the user may have named them from
/// elsewhere. Where the files stand in the text of now is known, as their paths are.
bool is_same_text(std::string_view before, std::string_view now, const std::vector<KnownFile>& files) {
  std::size_t first = now.npos;
  const KnownFile* file = nullptr;
  for (const KnownFile& one : files)  // the longest path first
    if (const auto at = now.find(one.path); at < first) first = at, file = &one;
  if (!file) return before == now;
  if (before.substr(0, first) != now.substr(0, first)) return false;
  before.remove_prefix(first);
  now.remove_prefix(first + file->path.size());
  for (auto at = before.find(file->name); at != before.npos; at = before.find(file->name, at + 1))
    if ((at == 0 || before[at - 1] == '/') && is_same_text(before.substr(at + file->name.size()), now, files))
      return true;
  return false;
}

/// Members that later versions write beside those of before, from what these say already.
constexpr std::array<std::string_view, 6> added_later{"about", "hidden", "lower", "memory", "models", "upper"};

bool is_added(const std::string& member) { return std::ranges::find(added_later, member) != added_later.end(); }

/// The same for all texts of two documents.
bool is_same(const Json& before, const Json& now, const std::vector<KnownFile>& files) {
  if (before.is_string() && now.is_string())
    return is_same_text(before.get_ref<const std::string&>(), now.get_ref<const std::string&>(), files);
  if (!before.is_structured() || before.type() != now.type()) return before == now;
  if (before.is_array())
    return std::ranges::equal(before, now,
                              [&](const Json& one, const Json& other) { return is_same(one, other, files); });
  for (const auto& [name, value] : now.items())
    if (!before.contains(name) && !is_added(name)) return false;
  return std::ranges::all_of(before.items(), [&](const auto& member) {
    const auto other = now.find(member.key());
    return other != now.end() && is_same(member.value(), *other, files);
  });
}

void compare_values(const Estimate& archived, const Estimate& estimate, Recomputation& out) {
  for (std::size_t i = 0; i < archived.parameters.size(); ++i) {
    const auto& parameter = archived.parameters[i];
    const auto* other = find_parameter(estimate, parameter.name);
    const double sd = standard_uncertainty(archived, i);
    const double difference = !other                            ? INFINITY
                              : other->value == parameter.value ? 0.0
                                                                : std::abs(other->value - parameter.value) / sd;
    if (difference > out.difference) out.difference = difference, out.parameter = parameter.name;
  }
}

}  // namespace

Recomputation recompute(const Archive& archive, const std::string& sha256, const std::string& scratch,
                        const Progress& progress) {
  const std::string text = result_text(archive, sha256);
  const Estimate archived = estimate_from_json(text, "result " + first_digits(sha256));
  const Workplace place = workplace_for(archived.provenance, fs::canonical(scratch).string());
  lay_out(archive, archived.provenance, place);
  const Estimate estimate = made_again(archived, place, progress);
  const std::string made = to_json(estimate), now = in_words_of(made, place);

  Recomputation out;
  out.archived_sha256 = sha256, out.new_sha256 = sha256_of(now);
  out.new_program = std::string(version);
  out.same_bytes = now == text;
  const Json before = Json::parse(text, nullptr, false), after = Json::parse(now, nullptr, false),
             in_scratch = Json::parse(made, nullptr, false);
  const auto files = known_files(archived.provenance, place);
  if (const auto found = before.find("tumble"); found != before.end() && found->is_string())
    out.archived_program = found->get<std::string>();
  for (const auto& [name, value] : before.items())
    if (name != "tumble" &&
        !(after.contains(name) && (after[name] == value || is_same(value, in_scratch.at(name), files))))
      out.differing.push_back(name);
  for (const auto& [name, value] : after.items())
    if (!before.contains(name) && !is_added(name)) out.differing.push_back(name);
  out.same = out.same_bytes || (out.differing.empty() && out.archived_program == out.new_program);
  if (!out.same) compare_values(archived, estimate, out);
  return out;
}

}  // namespace tumble
