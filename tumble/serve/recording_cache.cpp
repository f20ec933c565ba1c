#include "tumble/serve/recording_cache.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/pyramid/live_samples.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

namespace fs = std::filesystem;

namespace {

std::string text_of_sets(const Sets& sets) {
  std::string text;
  for (const auto& [key, value] : sets) text += key + "=" + value + "\n";
  return text;
}

/// What changes when a file does: its place, size, time and number; of a folder those of its files.
std::string key_of(const std::string& recording, const Sets& sets) {
  std::string text = fs::absolute(recording).lexically_normal().string();
  const auto add = [&](const fs::path& path) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0) throw Error{Error::Kind::bad_file, say("'{}' cannot be read", path.string())};
    text += fmt::format("\n{} {} {} {}.{}", path.string(), status.st_ino, status.st_size, status.st_mtim.tv_sec,
                        status.st_mtim.tv_nsec);
  };
  add(recording);
  if (fs::is_directory(recording))
    for (const auto& entry : fs::directory_iterator(recording)) add(entry.path());
  return sha256_of(text + "\n" + text_of_sets(sets));
}

/// Of a file that grows: its place and number.
std::string key_of_file(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) throw Error{Error::Kind::bad_file, say("'{}' cannot be read", path)};
  return fmt::format("live {} {}", status.st_ino,
                     first_digits(sha256_of(fs::absolute(path).lexically_normal().string()), 24));
}

/// Where the cache says which pyramid a file has: two lines, name of the pyramid and checksum of the file.
fs::path pointer_of(const fs::path& cache, const std::string& key) { return cache / (first_digits(key, 32) + ".of"); }

struct Names {
  std::string pyramid, checksum;
};

std::optional<Names> names_of(const fs::path& cache, const std::string& key) {
  std::error_code failed;
  const auto pointer = pointer_of(cache, key);
  if (!fs::exists(pointer, failed)) return std::nullopt;
  const auto text = read_text_file(pointer.string());
  const auto end = text.find('\n');
  if (end == std::string::npos || text.find_first_not_of("0123456789abcdef\n") != std::string::npos)
    return std::nullopt;
  Names names{text.substr(0, end), text.substr(end + 1)};
  if (names.checksum.ends_with('\n')) names.checksum.pop_back();
  if (!fs::exists(cache / (names.pyramid + ".pyr"), failed)) return std::nullopt;
  return names;
}

/// Most recordings of a list are never looked into: the file is opened when the first samples are asked for.
SampleReader opened_when_asked(const std::string& recording, const Sets& sets) {
  struct Opened {
    std::once_flag once;
    SampleReader reader;
  };
  auto opened = std::make_shared<Opened>();
  return [opened, recording, sets](std::size_t channel, std::size_t first, std::size_t count, std::vector<double>& to) {
    std::call_once(opened->once, [&] { opened->reader = sample_reader(recording, read_options(sets)); });
    if (!opened->reader) throw Error{Error::Kind::bad_file, say("'{}' changed: load the page again", recording)};
    opened->reader(channel, first, count, to);
  };
}

void write_names(const fs::path& cache, const std::string& key, const Names& names) {
  write_file_atomically(pointer_of(cache, key).string(), names.pyramid + "\n" + names.checksum + "\n");
}

/// A pyramid is named by the content of its recording, and by how it was read where that was said.
std::string pyramid_name(const std::string& checksum, const std::string& key, const Sets& sets) {
  if (checksum.empty()) return key;
  return sets.empty() ? checksum : sha256_of(checksum + "\n" + text_of_sets(sets));
}

/// Files that a program which was killed was building a day ago or more.
void remove_abandoned(const fs::path& cache) {
  std::error_code failed;
  const auto old = fs::file_time_type::clock::now() - std::chrono::hours(24);
  for (const auto& entry : fs::directory_iterator(cache, failed)) {
    const auto extension = entry.path().extension();
    const auto written = entry.last_write_time(failed);
    if ((extension == ".part" || extension == ".building") && !failed && written < old)
      fs::remove(entry.path(), failed);
  }
}

/// Gives a pyramid a second name: somebody may open the first.
void add_lasting_name(const fs::path& before, const fs::path& cache, const std::string& lasting) {
  const fs::path after = cache / (lasting + ".pyr");
  std::error_code failed;
  fs::create_hard_link(before, after, failed);
  if (!failed || fs::exists(after)) return;                                    // another server was there first
  const fs::path part = cache / fmt::format("{}.{}.part", lasting, getpid());  // a half copy has no lasting name
  fs::copy_file(before, part, fs::copy_options::overwrite_existing);
  fs::rename(part, after);
}

}  // namespace

void prepare_recording(
    const std::string& recording, const Sets& sets, const fs::path& cache,
    const std::function<std::string(const std::string&, const ReadOptions&, const Progress&)>& inspect,
    const Progress& progress) {
  const ReadOptions options = read_options(sets);
  fs::create_directories(cache);
  remove_abandoned(cache);
  const std::string key = key_of(recording, sets);
  auto names = names_of(cache, key);
  std::function<std::string()> checksum;
  if (!names) {
    const std::string building = (cache / fmt::format("{}.{}.building", key, getpid())).string();
    checksum = build_pyramid(recording, options, building, [&](double done, std::string_view) {
      report(progress, 0.6 * done, "preparing the view");
    });
    if (key_of(recording, sets) != key)
      throw Error{Error::Kind::bad_file, say("'{}' changed while it was read", recording)};
    names = Names{key, ""};  // it can be looked at before its checksum is known
    fs::rename(building, cache / (key + ".pyr"));
    write_names(cache, key, *names);
  }
  if (names->checksum.empty() && !fs::is_directory(recording)) {
    names->checksum = checksum ? checksum() : sha256_of_file(recording);
    const fs::path before = cache / (names->pyramid + ".pyr");
    names->pyramid = pyramid_name(names->checksum, key, sets);
    add_lasting_name(before, cache, names->pyramid);
    write_names(cache, key, *names);
    fs::remove(before);
  }
  const fs::path inspection = cache / (names->pyramid + ".json");
  if (fs::exists(inspection)) return;
  write_file_atomically(inspection.string(), inspect(recording, options, [&](double done, std::string_view) {
                          report(progress, 0.6 + 0.4 * done, "checking");
                        }));
}

std::shared_ptr<const PreparedRecording> RecordingCache::open(const std::string& recording, const Sets& sets,
                                                              const std::string& key) {
  for (int attempt = 0;; ++attempt) try {
      const auto names = names_of(cache_, key);
      if (!names) return nullptr;
      auto prepared = std::make_shared<PreparedRecording>();
      const fs::path file = cache_ / names->pyramid;
      prepared->pyramid = std::make_shared<const Pyramid>(file.string() + ".pyr", opened_when_asked(recording, sets));
      prepared->checksum = names->checksum;
      prepared->tag = first_digits(key, 32);
      std::error_code failed;
      if (fs::exists(file.string() + ".json", failed)) prepared->inspection = read_text_file(file.string() + ".json");
      return prepared;
    } catch (const Error&) {
      if (attempt == 1) throw;  // once, the pyramid may just have got its lasting name
    }
}

bool is_live(const fs::path& recording) { return recording.filename() == live_samples_name; }

/// Nothing is kept in the cache of it: the levels grow in memory as long as somebody looks.
RecordingState RecordingCache::live(const std::string& path) {
  const std::string key = key_of_file(path);
  std::shared_ptr<LiveRecording> recording;
  {
    const std::lock_guard lock(mutex_);
    const auto known = std::ranges::find(live_, key, [](const auto& entry) { return entry.first; });
    if (known != live_.end()) {
      live_.splice(live_.begin(), live_, known);
    } else {
      live_.emplace_front(key, std::make_shared<LiveRecording>(path));
      if (live_.size() > most_live) live_.pop_back();
    }
    recording = live_.front().second;
  }
  const auto now = recording->look();
  auto prepared = std::make_shared<PreparedRecording>();
  prepared->pyramid = now.pyramid;
  prepared->tag = key;
  prepared->live = {now.going_on, now.behind, now.target};
  return {prepared, {}, {}};
}

/// The way that was asked for the longest ago goes, with what was prepared for it.
void RecordingCache::remember_way(const std::string& recording, const std::string& key) {
  auto& ways = ways_[recording];
  ways.remove(key);
  ways.push_front(key);
  if (ways.size() <= most_ways) return;
  const std::string oldest = ways.back();
  ways.pop_back();
  open_.remove_if([&](const Entry& entry) { return entry.key == oldest; });
  if (const auto job = job_.find(oldest); job != job_.end()) {
    jobs_.cancel(job->second);
    job_.erase(job);
  }
  std::error_code failed;
  if (const auto names = names_of(cache_, oldest))
    for (const char* const extension : {".pyr", ".json"}) fs::remove(cache_ / (names->pyramid + extension), failed);
  fs::remove(pointer_of(cache_, oldest), failed);
}

RecordingState RecordingCache::find(const std::string& recording, const Sets& sets, bool start,
                                    const std::string& owner) {
  if (is_live(recording)) return live(recording);
  const std::string key = key_of(recording, sets);
  const std::lock_guard lock(mutex_);
  if (!sets.empty()) remember_way(recording, key);
  RecordingState state;
  const auto known = std::ranges::find(open_, key, &Entry::key);
  if (known != open_.end() && !known->prepared->inspection.empty()) {
    open_.splice(open_.begin(), open_, known);
    state.prepared = open_.front().prepared;
    return state;
  }
  if (known != open_.end()) open_.erase(known);
  if ((state.prepared = open(recording, sets, key))) {
    open_.push_front({key, state.prepared});
    if (open_.size() > most_open) open_.pop_back();
    if (!state.prepared->inspection.empty()) return state;
  }
  if (const auto before = job_.find(key); before != job_.end()) {
    const Job job = jobs_.find(before->second);
    if (job.state == Job::State::waiting || job.state == Job::State::running) state.job = job.id;
    if (job.state == Job::State::failed) state.problems = job.problems;
    if (!state.job.empty() || !state.problems.empty()) return state;
  }
  if (!start) return state;
  Job job;
  job.kind = "prepare";
  job.title = fs::path(recording).filename().string();
  job.kept = false;
  job.owner = owner;
  Job::Step step{"serve", "--prepare", recording};
  for (const auto& [name, value] : sets) step.push_back("--set=" + name + "=" + value);
  job.steps.push_back(step);
  job_[key] = state.job = jobs_.start(job);
  return state;
}

}  // namespace tumble
