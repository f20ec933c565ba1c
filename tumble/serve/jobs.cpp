#include "tumble/serve/jobs.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/job_members.hpp"
#include "tumble/serve/jobs/folder_below.hpp"
#include "tumble/serve/jobs/process.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* another_folder = "the folder of this job was removed or replaced: start the job again";

Json json_of(const Job& job) {
  Json json = Json::object();
  MembersToJson visit{JsonObject(&json)};
  members(visit, job);
  return json;
}

void take(CodedProblems found, Job& job) {
  job.code = std::move(found.code);
  job.problems = std::move(found.problems);
}

/// A job as its folder keeps it.
Job read_job(const fs::path& file) {
  const auto json = nlohmann::json::parse(read_text_file(file.string()));
  Job job;
  Problems problems;
  MembersFromJson visit(Node(&json, "", &problems));
  kept_members(visit, job);
  if (!problems.empty()) throw Error{Error::Kind::bad_file, problems};
  return job;
}

constexpr const char* place_of_jobs = "jobs";

bool is_number(const std::string& name) { return name.size() <= 9 && is_digits(name); }

std::vector<std::string> results_in(const jobs::Descriptor& folder) {
  auto files = jobs::files_in(folder);
  std::erase_if(files, [](const std::string& name) { return name == "job.json" || is_hidden(name); });
  return files;
}

Job::Step in_folder(Job::Step step, const std::string& folder) {
  constexpr std::string_view mark = "{folder}";
  for (std::string& word : step)
    if (word.starts_with(mark)) word.replace(0, mark.size(), folder);
  return step;
}

}  // namespace

const EnumerationWords& job_state_words() {
  static const EnumerationWords words{"waiting", "running", "done", "failed", "cancelled"};
  return words;
}

std::string name(Job::State state) { return job_state_words()[static_cast<std::size_t>(state)]; }

std::string to_json(const Job& job) { return json_text(json_of(job)); }

Jobs::Jobs(JobOptions options, EventFeed& feed) : options_(std::move(options)), feed_(feed) {
  restore();
  for (unsigned i = 0; i < options_.runners; ++i) runners_.emplace_back([this] { run_jobs(); });
}

Jobs::~Jobs() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    for (const auto& [id, process] : processes_) jobs::end_process(process);
  }
  work_.notify_all();
  for (auto& runner : runners_) runner.join();
}

std::string Jobs::folder_of(const Job& job) const {
  return (fs::path(options_.root) / place_of_jobs / job.id).string();
}

std::string Jobs::state_of(const Job& job) const { return (fs::path(options_.state) / (job.id + ".json")).string(); }

/// Folders of the root that have a number keep it, whoever made them.
void Jobs::restore() {
  std::error_code failed;
  const auto beyond = [&](const std::string& id) {
    if (is_number(id)) next_ = std::max<std::uint64_t>(next_, as_number<std::uint64_t>(id).value_or(0) + 1);
  };
  for (const auto& entry : fs::directory_iterator(fs::path(options_.root) / place_of_jobs, failed))
    beyond(entry.path().filename().string());
  if (options_.state.empty()) return;
  for (const auto& entry : fs::directory_iterator(options_.state, failed)) {
    const auto id = entry.path().stem().string();
    if (!is_number(id) || entry.path().extension() != ".json") continue;
    beyond(id);
    try {
      Job job = read_job(entry.path());
      if (job.id != id) continue;
      const bool unfinished = job.state == Job::State::running || job.state == Job::State::waiting;
      if (unfinished) job.state = has_its_folder(job) ? Job::State::waiting : Job::State::failed;
      if (job.state == Job::State::failed && unfinished) job.problems = {Problem(another_folder)};
      jobs_[id] = std::move(job);
    } catch (const std::exception&) {
      continue;  // of another version, or damaged
    }
  }
}

/// Whether the folder of a job is the one that was made for it, and no link on the way to it.
bool Jobs::has_its_folder(const Job& job) const {
  const auto folder = jobs::folder_below(options_.root, {place_of_jobs, job.id});
  return folder && jobs::number_of(folder) == job.folder;
}

void Jobs::make_folder(Job& job) {
  do job.id = fmt::format("{:06}", next_++);
  while (!jobs::make_folder_below(options_.root, place_of_jobs, job.id));
  job.folder = jobs::number_of(jobs::folder_below(options_.root, {place_of_jobs, job.id}));
}

void Jobs::require_room(const Job& job) const {
  const auto waiting = static_cast<std::size_t>(std::ranges::count_if(jobs_, [&](const auto& entry) {
    const Job& other = entry.second;
    return other.state == Job::State::waiting && other.kept == job.kept && other.owner == job.owner;
  }));
  if (waiting >= (job.kept ? most_waiting : most_unkept))
    throw Error{Error::Kind::bad_input,
                say("{} jobs of yours wait already: cancel some, or start this one when they have ended", waiting)};
}

std::string Jobs::start(Job job) {
  const std::lock_guard lock(mutex_);
  require_room(job);
  if (job.kept)
    make_folder(job);
  else
    job.id = fmt::format("p{}", next_++);
  job.state = Job::State::waiting;
  job.begun = options_.clock ? options_.clock() : 0.0;
  const auto id = job.id;
  forget_unkept();
  changed(jobs_[id] = std::move(job));
  work_.notify_one();
  return id;
}

/// What has no folder and has ended is of no use for long: the oldest go.
void Jobs::forget_unkept() {
  constexpr std::size_t most = 1000;
  std::vector<std::string> ended;
  for (const auto& [id, job] : jobs_)
    if (!job.kept && job.state != Job::State::waiting && job.state != Job::State::running) ended.push_back(id);
  std::ranges::sort(ended, {}, [&](const std::string& id) { return jobs_[id].begun; });
  for (std::size_t i = 0; i + most < ended.size(); ++i) jobs_.erase(ended[i]);
}

bool Jobs::cancel(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return false;
  Job& job = found->second;
  if (job.state != Job::State::waiting && job.state != Job::State::running) return false;
  const bool running = job.state == Job::State::running;
  job.state = Job::State::cancelled;
  if (running) jobs::end_process(processes_[id]);
  changed(job);
  return true;
}

std::vector<Job> Jobs::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<Job> list;
  for (const auto& [id, job] : jobs_) list.push_back(job);
  return list;
}

Job Jobs::find(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  return found == jobs_.end() ? Job{} : found->second;
}

std::function<bool(std::string& bytes)> Jobs::reader_of(const std::string& id, const std::string& file) const {
  const Job job = find(id);
  if (!job.kept || std::ranges::find(job.files, file) == job.files.end()) return {};
  const auto folder = jobs::folder_below(options_.root, {place_of_jobs, job.id});
  if (jobs::number_of(folder) != job.folder) return {};
  const auto opened = std::make_shared<jobs::Descriptor>(jobs::file_in(folder, file));
  if (!*opened) return {};
  return [opened](std::string& bytes) {
    constexpr std::size_t piece = 1 << 18;
    bytes.resize(piece);
    ssize_t count = 0;
    do count = ::read(opened->number(), bytes.data(), bytes.size());
    while (count < 0 && errno == EINTR);
    bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    if (count < 0) throw Error{Error::Kind::bad_file, "a file of a job cannot be read"};
    return count > 0;
  };
}

/// Tells everybody, and keeps what must survive. Called with the lock.
void Jobs::changed(const Job& job) {
  feed_.publish("job", json_text(json_of(job)));
  if (!job.kept || options_.state.empty()) return;
  Json json = Json::object();
  MembersToJson visit{JsonObject(&json)};
  kept_members(visit, job);
  try {
    write_file_atomically(state_of(job), json_text(json) + "\n");
  } catch (const Error&) {
    // A full disk keeps a job from being remembered, not from being done.
  }
}

/// That of the user who has the fewest running; what somebody waits for to see comes before what is kept.
Job* Jobs::next_waiting() {
  std::map<std::string, int> running;
  for (const auto& [id, job] : jobs_)
    if (job.state == Job::State::running) ++running[job.owner];
  Job* next = nullptr;
  const auto rank = [&](const Job& job) { return std::pair(running[job.owner], job.kept); };
  for (auto& [id, job] : jobs_)
    if (job.state == Job::State::waiting && (!next || rank(job) < rank(*next))) next = &job;
  return next;
}

void Jobs::run_jobs() {
  std::unique_lock lock(mutex_);
  for (;;) {
    Job* job = nullptr;
    work_.wait(lock, [&] { return ended_ || (job = next_waiting()) != nullptr; });
    if (ended_) return;
    job->state = Job::State::running;
    processes_[job->id] = 0;
    changed(*job);
    const std::string id = job->id;
    try {
      carry_out(lock, id);
    } catch (const std::exception& error) {  // no memory for what it says
      if (!lock.owns_lock()) lock.lock();
      jobs_[id].state = Job::State::failed;
      jobs_[id].problems = {Problem(error.what())};
    }
    processes_.erase(id);
  }
}

/// Steps one after the other until one fails; the lock is held except while a process runs.
void Jobs::carry_out(std::unique_lock<std::mutex>& lock, const std::string& id) {
  const auto steps = jobs_[id].steps;
  const auto folder = folder_of(jobs_[id]);
  const auto number = static_cast<double>(steps.size());
  for (std::size_t i = 0; i < steps.size() && jobs_[id].state == Job::State::running && !ended_; ++i) {
    if (jobs_[id].kept && !has_its_folder(jobs_[id])) {
      jobs_[id].state = Job::State::failed;
      jobs_[id].problems = {another_folder};
      break;
    }
    lock.unlock();
    const auto outcome = jobs::run_process(
        options_.program, in_folder(steps[i], folder),
        [&](int process) {
          const std::lock_guard inside(mutex_);
          processes_[id] = process;
          if (process > 0 && (ended_ || jobs_[id].state == Job::State::cancelled)) jobs::end_process(process);
        },
        [&](double done, const std::string& doing) {
          const std::lock_guard inside(mutex_);
          Job& job = jobs_[id];
          job.progress = (static_cast<double>(i) + done) / number;
          job.doing = doing;
          feed_.publish("job", json_text(json_of(job)));
        });
    lock.lock();
    Job& job = jobs_[id];
    if (ended_ || job.state == Job::State::cancelled) break;
    job.progress = static_cast<double>(i + 1) / number;
    if (outcome.status == 0) continue;
    job.state = Job::State::failed;
    take(jobs::problems_of(outcome, options_.root), job);
  }
  if (!ended_) settle(jobs_[id]);
}

/// What a job that has ended leaves: its results, and nothing that only its steps needed. Called with the lock.
void Jobs::settle(Job& job) {
  if (job.state == Job::State::running) job.state = Job::State::done;
  job.doing.clear();
  if (job.kept) {
    const auto own = jobs::folder_below(options_.root, {place_of_jobs, job.id});
    if (!job.scratch.empty() && job.scratch.find('/') == std::string::npos && jobs::number_of(own) == job.folder)
      unlinkat(own.number(), job.scratch.c_str(), 0);
    job.files = jobs::number_of(own) == job.folder ? results_in(own) : std::vector<std::string>();
  }
  changed(job);
}

}  // namespace tumble
