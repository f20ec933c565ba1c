#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

#include "tumble/desk/run_desk.hpp"
#include "tumble/station/guard.hpp"
#include "tumble/station/lease.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

bool goes_on(const LeaseHolder& run) {
  const auto all = runs_going_on();
  return std::ranges::find(all, run.run, &LeaseHolder::run) != all.end();
}

bool is_among(const std::vector<LeaseHolder>& runs, const std::string& wanted) {
  const std::string path = std::filesystem::absolute(wanted).lexically_normal().string();
  return std::ranges::find(runs, path, &LeaseHolder::run) != runs.end();
}

LeaseHolder chosen(const std::string& wanted) {
  const auto all = runs_going_on();
  std::string list;
  for (const auto& run : all) list += "\n  " + run.run;
  if (const std::string guarded = wanted.empty() ? "" : words_of_guard(wanted);
      !guarded.empty() && !is_among(all, wanted))
    throw Error(Error::Kind::bad_input, say("the run '{}' is not going on: {}", wanted, Name{guarded}));
  if (all.empty()) throw Error(Error::Kind::bad_input, "no run is going on on this machine");
  if (wanted.empty()) {
    if (all.size() == 1) return all.front();
    throw Error(Error::Kind::bad_input, say("several runs are going on; name one:{}", Name{list}));
  }
  const std::string path = std::filesystem::absolute(wanted).lexically_normal().string();
  const auto found = std::ranges::find(all, path, &LeaseHolder::run);
  if (found == all.end())
    throw Error(Error::Kind::bad_input, say("the run '{}' is not going on; these are:{}", path, Name{list}));
  return *found;
}

/// A rehearsal has no device of which it would hold the lease.
bool is_rehearsal(const std::string& wanted) {
  if (wanted.empty() || !process_at_desk(wanted)) return false;
  const std::string path = std::filesystem::absolute(wanted).lexically_normal().string();
  const auto all = runs_going_on();
  return std::ranges::find(all, path, &LeaseHolder::run) == all.end();
}

int run(const std::string& wanted, const Terminal& terminal) {
  using namespace std::chrono_literals;
  if (is_rehearsal(wanted)) {
    ask_desk(wanted, R"({"order":"stop","who":"tumble stop"})");
    print_said(terminal, say("the rehearsal '{}' is being stopped\n", wanted));
    return 0;
  }
  const LeaseHolder run = chosen(wanted);
  if (run.process <= 0 || kill(static_cast<pid_t>(run.process), SIGTERM) != 0)
    throw Error(Error::Kind::bad_file, say("the run '{}' (process {}) cannot be stopped from here: it belongs to "
                                           "another user",
                                           run.run, run.process));
  for (int tenths = 0; tenths < 1200; ++tenths) {
    if (!goes_on(run)) {
      print_said(terminal, say("the run '{}' has ended; it says whether the rig is safe\n", run.run));
      return 0;
    }
    std::this_thread::sleep_for(100ms);
  }
  complain(terminal, say("the run '{}' has not ended within 2 min: go to the rig", run.run));
  return 3;
}

}  // namespace

Verb stop_verb() {
  auto wanted = std::make_shared<std::string>();
  return {"stop",
          "Stop a run from another terminal: the rig goes to its safe state",
          {{"RUN", wanted.get(), "folder of the run; may be omitted where only one is active"}},
          "Example:\n"
          "  tumble stop run-0173\n",
          [wanted](const Terminal& terminal) { return run(*wanted, terminal); }};
}

}  // namespace tumble::cli
