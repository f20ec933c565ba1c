#include "tumble/station/station_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tumble/station/carry_out.hpp"
#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/units/testing/asserts.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

const std::string sound_station = R"(
[station]
name = "bench 3"
by_hand = ["mount_yaw"]

[power]
device = "supply"
off_time = "30 s"

[[device]]
name = "table"
controller = "acutrol_like"
link = "tcp:192.168.1.20:9878"
timeouts = {home = "60 s"}
on_lost_link = "stops in 1 s"
identity = "SN 12"
verbs = ["identify", "take", "position", "rate", "stop", "read", "home"]
once = ["home"]

[[device.axis]]
rig = "table"
sign = -1
offset = "90 deg"
lowest = "-180 deg"
highest = "180 deg"
max_rate = "200 deg/s"
turns = "counted"
settle = {position = "0.001 deg", rate = "0.002 deg/s", relative_rate = "50 ppm", hold = "2 s", timeout = "1 min"}

[[device]]
name = "supply"
controller = "scpi_supply"
link = "serial:/dev/ttyUSB0:9600"
verbs = ["start", "off", "read"]

[[instrument]]
slot = "1"
frames = "kvh_1775"
link = "serial:/dev/ttyS1:921600"
rate = "1 kHz"

[[interlock]]
require = "input.door == closed"
debounce = "100 ms"

[[hold]]
require = "room.temperature < 25 degC"

[[equipment]]
name = "rate table"
serial = "RT-12"
certificate = "C-77"
due = "2027-03-01"
)";

Problems problems_of_station(const std::string& text) {
  const Refused refusal = refusal_of([&] { read_station(text, "bench.toml"); });
  EXPECT_TRUE(refusal.empty() || refusal.kind == Error::Kind::bad_input);
  return refusal.problems;
}

std::string with_replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(StationFile, IsReadInSi) {
  const Station station = read_station(sound_station, "bench.toml");
  EXPECT_EQ(station.name, "bench 3");
  ASSERT_EQ(station.devices.size(), 2u);
  const auto& table = station.devices[0];
  EXPECT_EQ(table.poll, 0.1);
  EXPECT_EQ(table.lost_after, 0.5);
  EXPECT_EQ(table.timeouts.at(ControllerVerb::home), 60.0);
  EXPECT_EQ(table.stops_by_itself, 1.0);
  EXPECT_EQ(table.prepare, (std::vector{ControllerVerb::identify, ControllerVerb::take}));
  EXPECT_EQ(station.devices[1].lost_after, 10.0);
  ASSERT_EQ(station.axes.size(), 1u);
  const auto& axis = station.axes[0];
  EXPECT_EQ(axis.sign, -1);
  EXPECT_EQ(axis.offset, si(90.0, "deg"));
  EXPECT_EQ(axis.max_rate, si(200.0, "deg/s"));
  EXPECT_EQ(axis.turns, StationAxis::Turns::counted);
  EXPECT_DOUBLE_EQ(axis.settle.relative_rate, 50e-6);
  EXPECT_EQ(axis.settle.timeout, 60.0);
  EXPECT_EQ(station.power.device, 1u);
  ASSERT_EQ(station.interlocks.size(), 2u);
  EXPECT_EQ(station.interlocks[0].action, StationInterlock::Action::stop);
  EXPECT_EQ(station.interlocks[1].action, StationInterlock::Action::hold);
  EXPECT_EQ(station.interlocks[0].debounce, 0.1);
}

TEST(StationFile, RefusesWordsThatAreNoVerbs) {
  const auto of = [](const std::string& from, const std::string& to) {
    return problems_of_station(with_replaced(sound_station, from, to));
  };
  for (const auto& problems : {of("{home = \"60 s\"}", "{hom = \"60 s\"}"), of("once = [\"home\"]", "once = [\"hom\"]"),
                               of("\"read\", \"home\"]", "\"read\", \"home\", \"hom\"]")}) {
    ASSERT_EQ(problems.size(), 1u);
    EXPECT_TRUE(has_problem(problems, {.values = {"hom"}, .part = "home", .pattern = "unknown verb"}));
  }
}

TEST(StationFile, HasASafeListWhereItStatesNone) {
  const Station station = read_station(sound_station, "bench.toml");
  ASSERT_EQ(station.safe.size(), 2u);
  EXPECT_EQ(station.safe[0].request.verb, ControllerVerb::stop);
  EXPECT_FALSE(station.safe[0].wait);
  EXPECT_EQ(station.safe[1].request.verb, ControllerVerb::off);
  EXPECT_TRUE(station.safe[1].wait);
}

TEST(StationFile, RefusesASafeListThatLeavesAnAxisTurning) {
  const auto problems = problems_of_station(sound_station + "[[safe]]\ndevice = \"supply\"\nverb = \"off\"\n");
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_TRUE(is_problem(problems[0], {.values = {"table", "table", "1"},
                                       .pattern = "[[safe]]: nothing stops the axis",
                                       .file = "bench.toml",
                                       .line = 1}));
  EXPECT_TRUE(has_problem(
      problems_of_station(sound_station + "[[safe]]\ndevice = \"table\"\nverb = \"rate\"\n"),
      {.values = {"rate"}, .part = "stop, hold, off, disable, release", .table = "[[safe]]", .key = "verb"}));
}

TEST(StationFile, StatesAllProblemsWithLineAndNearestKey) {
  auto text = with_replaced(sound_station, "max_rate", "max_rat");
  text = with_replaced(text, "require = \"input.door == closed\"", "require = \"input.door ==\"");
  text = with_replaced(text, "device = \"supply\"", "device = \"suply\"");
  text = with_replaced(text, "due = \"2027-03-01\"", "due = \"1 March\"");
  text = with_replaced(text, "\"50 ppm\"", "\"50 deg\"");
  const auto problems = problems_of_station(text);
  ASSERT_EQ(problems.size(), 5u);
  EXPECT_TRUE(is_problem(problems[0], {.values = {"suply", "supply", "table, supply"},
                                       .file = "bench.toml",
                                       .table = "[power]",
                                       .key = "device",
                                       .line = 7}));
  EXPECT_TRUE(has_problem(problems, {.values = {"max_rat", "max_rate"}, .table = "[[device.axis]]", .line = 26}));
  EXPECT_TRUE(has_problem(problems, {.table = "[[device.axis]] settle", .key = "relative_rate", .line = 28}));
  EXPECT_TRUE(has_problem(problems, {.values = {"input.door ==", "14"}, .pattern = "a channel or a word"}));
  EXPECT_TRUE(has_problem(problems, {.pattern = "a date in quotes", .key = "due"}));
}

TEST(StationFile, SaysWhetherAllUnitsAreNeededAndHowLongAQuestionWaits) {
  EXPECT_FALSE(read_station(sound_station, "bench.toml").all_units);
  const std::string said =
      with_replaced(sound_station, "[station]\n", "[station]\nunits = \"all\"\nanswer_within = \"1 h\"\n");
  const Station station = read_station(said, "bench.toml");
  EXPECT_TRUE(station.all_units);
  EXPECT_EQ(station.answer_within, 3600.0);
  EXPECT_TRUE(has_problem(problems_of_station(with_replaced(said, "\"all\"", "\"both\"")),
                          {.table = "[station]", .key = "units"}));
  EXPECT_TRUE(has_problem(problems_of_station(with_replaced(said, "\"1 h\"", "\"0 s\"")),
                          {.pattern = "must be above zero", .key = "answer_within"}));
}

TEST(StationFile, RefusesWhatIsMissingOrTwice) {
  EXPECT_TRUE(has_problem(problems_of_station(""), {.values = {"[station]"}, .pattern = "is missing"}));
  EXPECT_TRUE(
      has_problem(problems_of_station("[station]\nname = \"a\"\n"), {.pattern = "[[device]]: a station needs"}));
  EXPECT_TRUE(has_problem(
      problems_of_station(with_replaced(sound_station, "link = \"tcp:192.168.1.20:9878\"", "link = \"usb\"")),
      {.pattern = "tcp:HOST:PORT or serial:DEVICE", .key = "link"}));
  EXPECT_TRUE(has_problem(
      problems_of_station(with_replaced(sound_station, "settle = {position = \"0.001 deg\", ", "settle = {")),
      {.values = {"position", "position"}, .pattern = "is missing"}));
  EXPECT_TRUE(has_problem(problems_of_station(with_replaced(sound_station, "name = \"supply\"", "name = \"table\"")),
                          {.values = {"table"}, .pattern = "two things are called"}));
  EXPECT_TRUE(has_problem(problems_of_station(with_replaced(sound_station, "[\"mount_yaw\"]", "[\"table\"]")),
                          {.values = {"table"}, .pattern = "moved by hand and by a device"}));
  EXPECT_TRUE(has_problem(problems_of_station(with_replaced(sound_station, "kvh_1775", "kvh_1757")),
                          {.values = {"kvh_1757", "kvh_1775"}}));
  EXPECT_TRUE(has_problem(problems_of_station(sound_station + "[[instrument]]\nslot = \"1\"\n"),
                          {.values = {"1"}, .pattern = "two slots", .key = "slot"}));
  EXPECT_TRUE(has_problem(problems_of_station("device = 3\nstation = 4\nsafe = [1]\n"),
                          {.pattern = "is a list of tables", .key = "safe"}));
}

Plan plan_of_table(Schedule schedule) {
  Plan plan;
  plan.rig_kind = "rate_table";
  plan.sample_rate = 1000.0;
  plan.schedule = std::move(schedule);
  return plan;
}

Motion held_at(double degrees) { return {.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; }
Motion turned_at(double value) { return {.kind = Motion::Kind::rate, .value = si(value, "deg/s")}; }

const StationRequest request_of_slot_1{.units = {{"1", "SN-5"}}, .date = "2026-11-24"};

TEST(StationCheck, AcceptsAPlanThatTheStationCanCarryOut) {
  const Station station = read_station(sound_station, "bench.toml");
  const auto plan = plan_of_table(
      {testing::bench_segment("rest", 10.0, {{"table", held_at(0.0)}, {"mount_yaw", held_at(90.0)}}),
       testing::bench_segment("turn", 1.0, {{"table", turned_at(60.0)}})});  // 180 deg in 1 s and 2 s of settling
  EXPECT_EQ(texts_of(check_station(plan, station, request_of_slot_1)), std::vector<std::string>{});
}

TEST(StationCheck, StatesAllRefusalsAtOnce) {
  Station station = read_station(sound_station, "bench.toml");
  station.equipment[0].due = "2026-11-23";
  station.axes[0].name = "tabel";
  const auto first =
      check_station(plan_of_table({testing::bench_segment("rest", 10.0, {{"table", held_at(0.0)}})}), station, {});
  EXPECT_TRUE(has_problem(first, {.values = {"tabel", "rate_table", "table"}, .pattern = "no such axis"}));
  EXPECT_TRUE(has_problem(first, {.values = {"rest", "table"}, .pattern = "no device of the station moves"}));
  EXPECT_TRUE(has_problem(first, {.values = {"1", "1"}, .pattern = "no serial number"}));
  EXPECT_TRUE(has_problem(first, {.values = {""}, .pattern = "is no date"}));

  station.axes[0].name = "table";
  Plan plan = plan_of_table(
      {testing::bench_segment("high", 10.0, {{"table", held_at(190.0)}}),
       testing::bench_segment("fast", 1.0, {{"table", turned_at(201.0)}}),
       testing::bench_segment("long", 10.0, {{"table", turned_at(100.0)}}),
       testing::bench_segment(
           "sine", 10.0,
           {{"table", Motion{.kind = Motion::Kind::sine, .amplitude = si(10.0, "deg"), .frequency = 10.0}}})});
  plan.sample_rate = 100.0;
  const StationRequest request{.units = {{"1", "SN-5"}, {"2", "SN-5"}, {"3", " "}}, .date = "2026-11-24"};
  const auto problems = check_station(plan, station, request);
  EXPECT_TRUE(has_problem(problems, {.values = {"high", "table", "190", "deg", "180", "deg"}}));
  EXPECT_TRUE(has_problem(problems, {.values = {"fast", "table", "201", "deg/s", "200", "deg/s"}}));
  EXPECT_TRUE(has_problem(problems, {.values = {"long", "table", "1200", "deg", "360", "deg"}}))
      << "2 s of settling too";
  EXPECT_TRUE(has_problem(problems, {.values = {"sine", "table", "sine", "acutrol_like"}, .pattern = "lacks"}));
  EXPECT_TRUE(has_problem(problems, {.values = {"sine", "table", "628.319", "deg/s"}}));
  EXPECT_TRUE(has_problem(problems, {.values = {"2", "1"}, .pattern = "the station has no slot"}));
  EXPECT_TRUE(has_problem(problems, {.values = {"SN-5", "1", "2"}}));
  EXPECT_TRUE(has_problem(problems, {.values = {"1", "1000", "100"}, .pattern = "Hz"}));
  for (const char* part : {"rate table RT-12", "C-77", "2026-11-23"})
    EXPECT_TRUE(has_problem(problems, {.part = part, .pattern = "--accept-expired"}));
  StationRequest accepted = request;
  accepted.accept_expired = "the laboratory is closed";
  EXPECT_EQ(check_station(plan, station, accepted).size(), problems.size() - 1);
}

TEST(StationCheck, RefusesARequestThatTheControllerWouldRefuseInMotion) {
  Station station = read_station(sound_station, "bench.toml");
  const auto plan = plan_of_table({testing::bench_segment("rest", 10.0, {{"table", held_at(0.0)}}),
                                   testing::bench_segment("again", 10.0, {{"table", held_at(1.0)}})});
  station.axes[0].speed = si(10.0, "deg/s");
  station.devices[0].takes[ControllerVerb::position] = {"position"};
  station.devices[0].needs[ControllerVerb::position] = {"position"};
  EXPECT_TRUE(check_station(plan, station, request_of_slot_1).empty()) << "the speed is omitted";
  station.axes[0].speed.reset();
  station.devices[0].takes[ControllerVerb::position] =
      station.devices[0].needs[ControllerVerb::position] = {"position", "rate"};
  const auto problems = check_station(plan, station, request_of_slot_1);
  ASSERT_EQ(problems.size(), 1u) << "once, however many segments";
  EXPECT_TRUE(is_problem(problems[0], {.values = {"table", "position", "acutrol_like", "rate"},
                                       .part = "add `speed` to the axis",
                                       .pattern = "needs"}));
}

TEST(StationCheck, AcceptsACalibrationOnItsLastDay) {
  Station station = read_station(sound_station, "bench.toml");
  station.equipment[0].due = request_of_slot_1.date;
  const auto plan = plan_of_table({testing::bench_segment("rest", 10.0, {{"table", held_at(0.0)}})});
  EXPECT_TRUE(check_station(plan, station, request_of_slot_1).empty());
}

/// A device with one axis.
Station station_of(const std::string& controller, const std::string& axis) {
  return read_station("[station]\nname = \"bench\"\n[[device]]\nname = \"it\"\ncontroller = \"" + controller +
                          "\"\nlink = \"tcp:host:1\"\n[[device.axis]]\n" + axis,
                      "bench.toml");
}

const std::string chamber_axis =
    "rig = \"chamber\"\nmoves = \"temperature\"\nsettle = {temperature = \"0.5 K\", hold = \"1 min\"}\n";
const std::string table_axis =
    "rig = \"table\"\nsettle = {position = \"0.1 deg\", rate = \"0.1 deg/s\", hold = \"2 s\"}\n";

TEST(StationFile, NothingMovesWhileDevicesArePrepared) {
  const auto starts = [](const Station& station) {
    const auto& prepare = station.devices[0].prepare;
    return std::ranges::find(prepare, ControllerVerb::start) != prepare.end();
  };
  EXPECT_TRUE(starts(station_of("espec_p300", chamber_axis)));
  EXPECT_FALSE(starts(station_of("mn_three_axis", table_axis))) << "MNRUN begins the motion that was loaded last";
  EXPECT_FALSE(starts(station_of("vibrationview", "rig = \"shake\"\nmoves = \"acceleration\"\n")));
  EXPECT_FALSE(starts(station_of("voetsch_ascii2", chamber_axis))) << "it needs a temperature";
}

TEST(StationFile, ASpeedAboveTheRateOfTheAxisIsRefused) {
  const auto problems = problems_of_station(
      with_replaced(sound_station, "max_rate = \"200 deg/s\"", "max_rate = \"20 deg/s\"\nspeed = \"30 deg/s\""));
  EXPECT_TRUE(has_problem(problems, {.pattern = "must not be above `max_rate`", .key = "speed"}));
}

/// Problems of a plan with these segments at a table that turns from -180 to 180 deg.
Problems problems_of_motions(const Station& station, const std::vector<Motion>& motions) {
  Plan plan;
  for (const Motion& motion : motions) plan.schedule.push_back({"it", 30.0, 1, {{"table", motion}}});
  return check_station(plan, station, {.rehearsed = true});
}

TEST(StationFile, MotionsThatLeaveTheTravelFromWhereTheAxisStandsAreRefused) {
  const Station station = station_of("scpi_like", table_axis + "lowest = \"-180 deg\"\nhighest = \"180 deg\"\n");
  const Motion aside{.value = si(170.0, "deg")}, middle{.value = 0.0};
  const Motion sine{.kind = Motion::Kind::sine, .amplitude = si(15.0, "deg"), .frequency = 0.1};
  const Motion turn{.kind = Motion::Kind::rate, .value = si(5.5, "deg/s")};
  EXPECT_TRUE(has_problem(problems_of_motions(station, {aside, sine}),
                          {.values = {"it", "table", "185", "deg", "180", "deg"}}));
  EXPECT_TRUE(problems_of_motions(station, {middle, sine}).empty());
  EXPECT_TRUE(problems_of_motions(station, {middle, turn}).empty()) << "5.5 deg/s for 30 s and the 2 s of settling";
  EXPECT_TRUE(has_problem(problems_of_motions(station, {aside, turn}),
                          {.values = {"it", "table", "346", "deg", "180", "deg"}}));
}

TEST(StationFile, ASlewNeedsACommandThatCarriesItsSpeed) {
  const Motion slew{.kind = Motion::Kind::slew, .value = si(5.0, "deg/s"), .to = si(90.0, "deg")};
  EXPECT_TRUE(has_problem(problems_of_motions(station_of("atl_like", table_axis), {slew}),
                          {.values = {"table", "position", "atl_like"}, .pattern = "slews at a speed"}));
  EXPECT_TRUE(problems_of_motions(station_of("scpi_like", table_axis), {slew}).empty());
}

TEST(StationFile, ASerialLineHasTheRateAndTheFramingOfItsDeclaration) {
  for (const auto& [link, whole] : {std::pair{"serial:/dev/ttyUSB0", "serial:/dev/ttyUSB0:19200:8O1"},
                                    {"serial:/dev/ttyUSB0:9600", "serial:/dev/ttyUSB0:9600:8O1"},
                                    {"serial:/dev/ttyUSB0:9600:8N1", "serial:/dev/ttyUSB0:9600:8N1"},
                                    {"tcp:host:1", "tcp:host:1"}}) {
    Station station = station_of("cts_serial", chamber_axis);
    station.devices[0].link = link;
    parts_of(station);
    EXPECT_EQ(station.devices[0].link, whole);
  }
}

}  // namespace
}  // namespace tumble
