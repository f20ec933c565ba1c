// A run that another process watches, answers and gives orders.
#include "tumble/desk/run_desk.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "tumble/desk/testing/shown_items.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/rehearsal/testing/served_rig.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using Json = nlohmann::json;
using testing::run_over_tcp;
using testing::station_over_tcp;

constexpr double fast = 20.0;  ///< [1] of the clock of the rig

/// Two segments of so many seconds; the unit is mounted by hand, which is a question.
Plan short_turning_plan(double seconds) {
  Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {});
  plan.schedule.resize(2);
  for (Segment& segment : plan.schedule) segment.duration = seconds;
  return plan;
}

/// A run with a desk in a thread; nobody sits at its terminal.
struct WatchedRun {
  ScratchFolder scratch;
  Plan plan;
  Station station;
  ServedRig rig;
  std::string folder;
  RunEnd end;
  std::thread thread;

  explicit WatchedRun(const std::string& name = "run", double seconds = 5.0)
      : plan(short_turning_plan(seconds)),
        station(station_over_tcp(plan, scratch)),
        rig(plan, station, fast),
        folder(scratch.file(name)) {
    thread = std::thread([this] {
      RunDesk desk;
      PlannedRunAtStation run = run_over_tcp(plan, station, folder, fast);
      run.company.ask = {};
      run.desk = &desk;
      end = run_plan(run);
      desk.ended(end);
    });
    for (int tenths = 0; tenths < 300 && !process_at_desk(folder); ++tenths) pause();
  }
  ~WatchedRun() { finish(); }
  void finish() {
    if (thread.joinable()) thread.join();
  }
  static void pause() { std::this_thread::sleep_for(std::chrono::milliseconds(100)); }
  Json state() const { return Json::parse(ask_desk(folder, R"({"ask":"state"})")); }
  /// The state as soon as this holds of it.
  Json state_when(const std::function<bool(const Json&)>& holds) const {
    for (int tenths = 0; tenths < 300; ++tenths) {
      const Json now = state();
      if (holds(now)) return now;
      pause();
    }
    ADD_FAILURE() << "it has not come to this: " << state()["view"].dump();
    return state();
  }
  Refused refusal(const Json& request) const {
    return refusal_of([&] { ask_desk(folder, request.dump()); });
  }
};

bool asks(const Json& state) { return state["view"].is_object() && state["view"].contains("prompt"); }
bool is_in(const Json& state, const char* phase) {
  return state["view"].is_object() && state["view"]["phase"] == phase;
}

TEST(RunDesk, AQuestionIsAnsweredFromElsewhereAndNothingThatHappensIsMissed) {
  WatchedRun run;
  DeskWatch watch(run.folder);
  const Json open = run.state_when(asks);
  const int question = open["view"]["prompt"]["id"];
  const auto refused = [&](const Asked& asked, const Json& order) {
    return refuses(Error::Kind::bad_input, asked, run.refusal(order));
  };
  const Asked closed{.values = {std::to_string(question)}, .pattern = "is closed"};
  const Json answer{{"order", "answer"}, {"prompt", question}, {"choice", "done"}, {"who", "Li Wei"}};
  const auto changed = [&](const char* key, const Json& value) {
    Json order = answer;
    order[key] = value;
    return order;
  };
  EXPECT_TRUE(refused({.pattern = "an order needs a name"}, changed("who", "")));
  EXPECT_TRUE(
      refused({.values = {std::to_string(question + 1)}, .pattern = "is closed"}, changed("prompt", question + 1)));
  EXPECT_TRUE(refused({.values = {"perhaps", std::to_string(question)}, .part = "done", .pattern = "no answer"},
                      changed("choice", "perhaps")));
  EXPECT_TRUE(run.refusal(answer).empty());
  EXPECT_TRUE(refused(closed, answer)) << "it is answered once";
  run.finish();
  EXPECT_EQ(run.end.ending, RunEnding::complete) << run.end.text.text();

  std::vector<std::uint64_t> seen;
  std::uint64_t last = 0;
  std::size_t views = 0;
  bool ended = false, answered = false;
  while (const auto line = watch.next()) {
    EXPECT_GE(line->sequence, last) << "an id never falls";
    last = line->sequence;
    if (line->name == "happened") {
      seen.push_back(line->sequence);
      answered = answered || Json::parse(line->json)["text"] == "Li Wei: 'done' to question 1";
    }
    views += line->name == "view";
    ended = ended || line->name == "ended";
  }
  EXPECT_TRUE(ended);
  EXPECT_TRUE(answered) << "who and what";
  EXPECT_GT(views, 0u);
  // What the store has, except what was written before the run begins and after it has ended.
  std::vector<std::uint64_t> stored;
  visit_events(run.folder, [&](const StoreItem& item) {
    const bool beside = item.event && (item.event->kind == EventKind::end || item.event->kind == EventKind::clock);
    if (testing::is_shown(item) && !beside) stored.push_back(item.sequence);
  });
  EXPECT_EQ(seen, stored);
}

TEST(RunDesk, ARunIsPausedCarriedOnAndStoppedFromElsewhere) {
  WatchedRun run("run", 40.0);
  const Json open = run.state_when(asks);
  ask_desk(run.folder, Json{{"order", "pause"}, {"who", "Li Wei"}}.dump());
  ask_desk(run.folder,
           Json{{"order", "answer"}, {"prompt", open["view"]["prompt"]["id"]}, {"choice", "done"}, {"who", "Li Wei"}}
               .dump());
  run.state_when([](const Json& now) { return is_in(now, "paused"); });
  ask_desk(run.folder, R"({"order":"resume","who":"Li Wei"})");
  run.state_when([](const Json& now) { return !is_in(now, "paused"); });
  EXPECT_EQ(ask_desk(run.folder, R"({"order":"stop","who":"Li Wei"})"), R"({"taken":true})");
  run.finish();
  EXPECT_EQ(run.end.ending, RunEnding::stopped) << run.end.text.text();
  EXPECT_FALSE(process_at_desk(run.folder));
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::path(run.folder) / desk_name));
  EXPECT_TRUE(refuses(Error::Kind::unsupported, Asked{.values = {run.folder}, .pattern = "does not go on"}, [&] {
    ask_desk(run.folder, R"({"ask":"state"})");
  })) << "it does not go on";
}

TEST(RunDesk, TheStateOfARunIsTheSameWhenItHasEnded) {
  WatchedRun run(std::string(180, 'x'), 40.0);  // longer than a name of a socket may be; views come every 10 s
  const Json open = run.state_when(asks);
  struct stat socket {};
  ASSERT_EQ(stat((std::filesystem::path(run.folder) / desk_name).c_str(), &socket), 0);
  EXPECT_EQ(socket.st_mode & 0777, 0600u) << "for the user of the run alone";
  ask_desk(run.folder,
           Json{{"order", "answer"}, {"prompt", open["view"]["prompt"]["id"]}, {"choice", "done"}, {"who", "Li Wei"}}
               .dump());
  const Json live =
      run.state_when([](const Json& now) { return is_in(now, "recording") && now["view"]["segment"] == 1; });
  EXPECT_EQ(live["view"]["segments"][0]["state"], "done");
  EXPECT_EQ(live["view"]["segments"][1]["state"], "now");
  EXPECT_FALSE(live["curves"]["whole"].empty());
  run.finish();
  const Json stored = Json::parse(state_of_ended_run(run.folder));
  for (const char* fact : {"title", "station", "operator", "units", "rig"})
    EXPECT_EQ(stored["facts"][fact], live["facts"][fact]) << fact;
  EXPECT_EQ(stored["facts"]["segments"][1]["label"], live["facts"]["segments"][1]["label"]);
  EXPECT_EQ(stored["ending"], "complete");
  EXPECT_EQ(stored["segments"][1]["state"], "done");
  for (const Json& event : live["events"])
    EXPECT_NE(std::ranges::find(stored["events"], event), stored["events"].end()) << event;
}

/// A run that was killed may have left the rig in motion, also where it had ended well once before.
TEST(RunDesk, ARunThatWasCarriedOnAndKilledIsNotCalledSafe) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("run");
  std::filesystem::create_directory(folder);
  const auto ending = [&] { return Json::parse(state_of_ended_run(folder))["ending"]; };
  Disk disk;
  RecorderOptions options;
  options.reserve_bytes = 0;
  {
    Recorder recorder(folder, disk, options);
    recorder.event({1.0, EventKind::phase, {}, "stopping -> safe", {}});
    recorder.close(2.0, "stopped");
  }
  EXPECT_EQ(ending(), "stopped");
  options.resume = true;
  { Recorder(folder, disk, options).event({3.0, EventKind::phase, {}, "idle -> preparing", {}}); }
  EXPECT_EQ(ending(), "interrupted");
  Recorder(folder, disk, options).close(4.0, "complete");
  EXPECT_EQ(ending(), "complete");
}

TEST(RunDesk, WhatIsNoRequestIsRefused) {
  WatchedRun run;
  for (const char* request : {"", "{", "[]", "7", R"({"ask":"everything"})", R"({"order":7})", R"({"ask":[]})"})
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "the request is not"}, [&] {
      ask_desk(run.folder, request);
    })) << request;
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"faster"}, .pattern = "is no order"},
                      run.refusal({{"order", "faster"}, {"who", "x"}})));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {run.folder}, .pattern = "has not answered"}, [&] {
    ask_desk(run.folder, std::string(1 << 17, 'x'));
  })) << "a line that does not end";
  ask_desk(run.folder, R"({"order":"abort","who":"Li Wei"})");
  run.finish();
  EXPECT_EQ(run.end.ending, RunEnding::aborted);
}

/// One who never reads is hung up on; the run and the others do not wait.
TEST(RunDesk, OneWhoDoesNotReadHoldsNobodyUp) {
  WatchedRun run;
  std::vector<std::unique_ptr<DeskWatch>> sleepers;
  for (int i = 0; i < 20; ++i) sleepers.push_back(std::make_unique<DeskWatch>(run.folder));
  run.state_when(asks);
  ask_desk(run.folder, R"({"order":"stop","who":"Li Wei"})");
  run.finish();
  EXPECT_EQ(run.end.ending, RunEnding::stopped);
}

}  // namespace
}  // namespace tumble
