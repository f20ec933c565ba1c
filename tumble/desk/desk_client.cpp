// The side of those who watch a run.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <utility>

#include "tumble/core/json_text.hpp"
#include "tumble/desk/desk_lines/run_json.hpp"
#include "tumble/desk/run_desk.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/station/lease.hpp"
#include "tumble/station/run_folder.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double patience_of_watch = 2.0;  ///< [s] until a run must have taken a new connection

/// A connection to a desk.
struct DeskConnection {
  int socket = -1;    ///< -1: there is none
  bool full = false;  ///< somebody is there, and does not take what others say
};

timeval time_of(double seconds) {
  constexpr double microseconds = 1e6;
  const auto all = static_cast<long>(seconds * microseconds);
  return {.tv_sec = all / 1'000'000, .tv_usec = all % 1'000'000};
}

/// Whoever does not take it within `patience` [s] is not waited for. What is no socket of the folder itself is no desk.
DeskConnection connected_to(const std::string& run, double patience) {
  const int folder = open(run.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return {};
  struct stat status {};
  const std::string name(desk_name);
  const bool is_desk = fstatat(folder, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISSOCK(status.st_mode);
  sockaddr_un place{};
  place.sun_family = AF_UNIX;
  const auto path = fmt::format("/proc/self/fd/{}/{}", folder, desk_name);
  std::memcpy(place.sun_path, path.c_str(), path.size() + 1);
  const int socket = is_desk ? ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0) : -1;
  const timeval limit = time_of(patience);
  if (socket >= 0) setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);  // of connect(), too
  const bool good = socket >= 0 && connect(socket, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0;
  const bool full = socket >= 0 && !good && errno == EAGAIN;
  close(folder);
  if (good) return {socket, false};
  if (socket >= 0) close(socket);
  return {-1, full};
}

[[noreturn]] void refuse_silent(const std::string& run) {
  throw Error(Error::Kind::bad_file, say("the run '{}' has not answered", run));
}

int connection_to(const std::string& run, double patience) {
  const auto [socket, full] = connected_to(run, patience);
  if (full) refuse_silent(run);
  if (socket < 0) throw Error(Error::Kind::unsupported, say("the run '{}' does not go on", run));
  return socket;
}

void say_all(int socket, std::string text) {
  text += '\n';
  for (std::size_t sent = 0; sent < text.size();) {
    const auto count = send(socket, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;  // the answer that does not come says it
    sent += static_cast<std::size_t>(count);
  }
}

using DeskClock = std::chrono::steady_clock;

/// The next line; empty: there is no more, or it has not come until then.
std::string next_line(int socket, std::string& waiting, std::optional<DeskClock::time_point> until = std::nullopt) {
  std::size_t searched = 0;
  for (;;) {
    if (const auto end = waiting.find('\n', searched); end != std::string::npos) {
      std::string line = waiting.substr(0, end);
      waiting.erase(0, end + 1);
      return line;
    }
    searched = waiting.size();
    if (until) {
      const double left = std::chrono::duration<double>(*until - DeskClock::now()).count();
      if (left <= 0.0) return "";
      const timeval limit = time_of(std::max(left, 1e-3));
      setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    }
    char bytes[1 << 14];
    const auto count = recv(socket, bytes, sizeof bytes, 0);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return "";
    waiting.append(bytes, static_cast<std::size_t>(count));
  }
}

/// The process that has the lease of a device for this run.
std::optional<long> process_with_lease(const std::string& run) {
  const auto all = runs_going_on();
  const auto path = std::filesystem::absolute(run).lexically_normal().string();
  const auto leased = std::ranges::find(all, path, &LeaseHolder::run);
  return leased == all.end() ? std::nullopt : std::optional(leased->process);
}

}  // namespace

std::string ask_desk(const std::string& run, const std::string& request, double patience) {
  const auto until =
      DeskClock::now() + std::chrono::duration_cast<DeskClock::duration>(std::chrono::duration<double>(patience));
  const int socket = connection_to(run, patience);
  say_all(socket, request);
  std::string waiting;
  const std::string answer = next_line(socket, waiting, until);
  close(socket);
  if (answer.empty()) refuse_silent(run);
  if (!answer.starts_with("{\"problem\"")) return answer;
  throw Error(Error::Kind::bad_input,
              coded_problems_from_json(desk_lines::Json::parse(answer).at("problems").dump()).problems);
}

std::optional<long> process_at_desk(const std::string& run) {
  constexpr double moment = 0.05;  // [s]
  const auto [socket, full] = connected_to(run, moment);
  if (full) return process_with_lease(run);
  if (socket < 0) return std::nullopt;
  ucred who{};
  socklen_t size = sizeof who;
  const bool known = getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0;
  close(socket);
  return known ? std::optional<long>(who.pid) : std::nullopt;
}

void stop_run(const std::string& run, const std::string& who, double patience) {
  const std::string order = json_text(desk_lines::Json{{"order", "stop"}, {"who", who}});
  try {
    ask_desk(run, order, patience);
    return;
  } catch (const Error& error) {
    if (error.kind == Error::Kind::bad_input) throw;
  }
  auto process = process_at_desk(run);
  if (!process) process = process_with_lease(run);
  if (!process) throw Error(Error::Kind::unsupported, say("the run '{}' does not go on", run));
  if (*process <= 0 || kill(static_cast<pid_t>(*process), SIGTERM) != 0 ||
      kill(static_cast<pid_t>(*process), SIGCONT) != 0)
    throw Error(Error::Kind::bad_file, say("the run '{}' cannot be stopped from here: go to the rig", run));
  try {
    ask_desk(run, order, patience);
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_file) return;  // it has ended, or is about to
    throw Error(Error::Kind::bad_file,
                say("the run '{}' does not answer; its process {} has got the signal to stop: watch the rig, and "
                    "press its emergency stop if it moves on",
                    run, *process));
  }
}

DeskWatch::DeskWatch(const std::string& run) : socket_(connection_to(run, patience_of_watch)) {
  say_all(socket_, R"({"ask":"watch"})");
}

DeskWatch::~DeskWatch() { ::close(socket_); }

std::optional<DeskWatch::Line> DeskWatch::next() {
  const std::string text = next_line(socket_, waiting_);
  const auto first = text.find(' '), second = text.find(' ', first + 1);
  if (first == std::string::npos || second == std::string::npos) return std::nullopt;
  Line line{text.substr(0, first), 0, text.substr(second + 1)};
  std::from_chars(text.data() + first + 1, text.data() + second, line.sequence);
  return line;
}

void DeskWatch::close() { shutdown(socket_, SHUT_RDWR); }

RunFacts facts_of(const std::string& title, const Course& course, const std::string& who, const std::string& rig) {
  RunFacts facts{title, course.station.name, who, rig, {}, {}};
  for (const UnitUnderTest& unit : course.units) facts.units[unit.slot] = unit.serial;
  for (const Segment& segment : course.schedule) {
    const auto rule = course.until.find(segment.label);
    facts.segments.push_back({segment.label, segment.duration, rule == course.until.end() ? "" : rule->second.text});
  }
  return facts;
}

namespace {

/// The schedule of a run that has ended; empty where its folder has no plan.
Course course_of(const std::string& run, const StoreContent& content) {
  Course course;
  try {
    const Plan plan = load_plan((std::filesystem::path(run) / "plan.toml").string(), {});
    course.schedule = plan.schedule;
    course.until = stopping_rules(plan);
  } catch (const Error&) {  // a rehearsal of a changed plan may have none: its log is shown all the same
  }
  for (const auto& [slot, serial] : content.units) course.units.push_back({slot, serial});
  return course;
}

std::vector<SegmentProgress> progress_of(const std::vector<RunRow>& rows, std::size_t segments) {
  std::vector<SegmentProgress> progress(segments);
  for (const RunRow& row : rows)
    if (row.kind == RunRow::Kind::segment_begins && row.segment < segments)
      progress[row.segment].attempts = std::max(progress[row.segment].attempts, row.attempt);
  for (const auto& [segment, attempt] : counted_attempts(rows))
    if (segment < segments) progress[segment].status = SegmentProgress::Status::complete;
  return progress;
}

}  // namespace

std::string state_of_ended_run(const std::string& run) {
  using desk_lines::Json;
  Json events = Json::array();
  std::vector<RunRow> rows;
  std::string ending;
  Sentence reason;
  std::uint64_t last = 0;
  const StoreContent content = visit_events(run, [&](const StoreItem& item) {
    last = item.sequence;
    const bool ends = item.event && item.event->kind == EventKind::end;
    if (!ending.empty() && !ends) ending.clear(), reason = {};  // it was carried on
    if (ends) ending = item.event->text;
    if (item.journal) rows.push_back(*item.journal);
    if (item.journal && item.journal->kind == RunRow::Kind::run_ends) reason = item.journal->reason;
    if (desk_lines::is_shown(item)) events.push_back(desk_lines::json_of(item));
  });
  const auto fact = [&](const std::string& name) {
    const auto found = content.facts.find(name);
    return found == content.facts.end() ? std::string() : found->second;
  };
  Course course = course_of(run, content);
  course.station.name = fact("station");
  const auto progress = progress_of(rows, course.schedule.size());
  Json state{{"alive", false}, {"last", last}, {"ending", ending.empty() ? "interrupted" : ending}};
  desk_lines::put_said(state, "ending_text", reason);
  state["facts"] = desk_lines::json_of(facts_of(fact("title"), course, fact("operator"), fact("rig")));
  state["view"] = nullptr;
  state["segments"] = desk_lines::json_of(progress, progress.size());
  state["curves"] = nullptr;
  state["estimates"] = Json::array();
  state["events"] = std::move(events);
  return json_text(state);
}

}  // namespace tumble
