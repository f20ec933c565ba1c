#include <gtest/gtest.h>

#include <cmath>

#include "tumble/core/evidence.hpp"
#include "tumble/language/say.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

Channel uniform(std::string name, std::size_t count, double rate, double start = 0.0) {
  Channel channel;
  channel.name = std::move(name);
  channel.timeline = {start, rate, nullptr};
  channel.values.assign(count, 0.0);
  return channel;
}

TEST(Channel, KindFollowsFromTheUnit) {
  EXPECT_EQ(kind_of(Unit::parse("deg/h")), QuantityKind::angular_rate);
  EXPECT_EQ(kind_of(Unit::parse("arcsec")), QuantityKind::angle);
  EXPECT_EQ(kind_of(Unit::parse("mg")), QuantityKind::specific_force);
  EXPECT_EQ(kind_of(Unit::parse("m/s")), QuantityKind::velocity);
  EXPECT_EQ(kind_of(Unit::parse("pulse")), QuantityKind::count);
  EXPECT_EQ(kind_of(Unit::parse("degC")), QuantityKind::temperature);
  EXPECT_EQ(kind_of(Unit::parse("ms")), QuantityKind::time);
  EXPECT_EQ(kind_of(Unit::parse("V")), QuantityKind::other);
  EXPECT_EQ(name(QuantityKind::specific_force), "specific_force");
}

TEST(Channel, IndexIsTheFirstSampleAtOrAfter) {
  const Channel even = uniform("x", 1000, 3.0, 100.0);
  for (std::size_t i = 0; i < 1000; ++i) {
    ASSERT_EQ(index_at(even, even.time(i)), i);
    ASSERT_EQ(index_at(even, std::nextafter(even.time(i), 1e9)), i + 1);
  }
  EXPECT_EQ(index_at(even, -INFINITY), 0u);
  EXPECT_EQ(index_at(even, INFINITY), 1000u);
  Channel stamped = uniform("x", 4, 0.0);
  stamped.timeline.stamps = std::make_shared<const std::vector<double>>(std::vector<double>{0, 1, 1, 5});
  EXPECT_EQ(index_at(stamped, 1.0), 1u);
  EXPECT_EQ(index_at(stamped, 2.0), 3u);
  EXPECT_EQ(index_at(stamped, 6.0), 4u);
  EXPECT_DOUBLE_EQ(mean_rate(stamped), 0.6);
  EXPECT_EQ(span(stamped), 5.0);
  EXPECT_EQ(mean_rate(uniform("x", 1, 10.0)), 0.0);
  EXPECT_EQ(span(uniform("x", 11, 10.0)), 1.0);
}

TEST(Evidence, ChannelsByRole) {
  Evidence evidence;
  evidence.plan.channels["gyro"] = {{"dtg.x", {}}};
  Recording recording;
  recording.channels = {uniform("dtg.x", 1, 1.0), uniform("temperature", 1, 1.0)};
  recording.origin.file = "run.csv";
  EXPECT_EQ(channel_for(evidence, recording, "gyro")->name, "dtg.x");
  EXPECT_EQ(channel_for(evidence, recording, "temperature")->name, "temperature");
  EXPECT_EQ(channel_for(evidence, recording, "accelerometer"), nullptr);
  EXPECT_TRUE(channels_for(evidence, recording, "accelerometer").empty());
  evidence.plan.channels["gyro"] = {{"dtg.y", {}}};
  EXPECT_TRUE(refuses(Error::Kind::bad_data,
                      Asked{.values = {"run.csv", "dtg.y", "gyro", "dtg.x", "dtg.x, temperature"}},
                      [&] { require_channel(evidence, recording, "gyro"); }));
}

TEST(Evidence, SeveralChannelsOfOneRole) {
  Evidence evidence;
  Recording recording;
  recording.channels = {uniform("accelerometer", 1, 1.0), uniform("S2.accelerometer", 1, 1.0),
                        uniform("reference", 1, 1.0)};
  const auto names = [&] {
    std::string list;
    for (const Channel* channel : channels_for(evidence, recording, "accelerometer")) list += channel->name + " ";
    return list;
  };
  EXPECT_EQ(names(), "accelerometer S2.accelerometer ");
  evidence.plan.channels["accelerometer"] = {{"reference", {}}, {"lost", {}}, {"accelerometer", {}}};
  EXPECT_EQ(names(), "reference accelerometer ");
}

TEST(Evidence, RunsOfMarkedAndUnmarkedRecordings) {
  Recording marked, plain;
  marked.marks = {{"soak", 0.0, 1}, {"ramp", 60.0, 1}, {"soak", 200.0, 2}};
  const auto runs = runs_of({marked, plain});
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_EQ(runs[0].label, "soak");
  EXPECT_EQ(runs[0].end, 200.0);
  EXPECT_EQ(runs[1].begin, 200.0);
  EXPECT_EQ(runs[1].end, INFINITY);
  EXPECT_EQ(runs[2].number, 3);
  EXPECT_EQ(runs[2].recording, 1u);
  EXPECT_EQ(runs[2].begin, -INFINITY);
}

TEST(Say, SensibleDigits) {
  EXPECT_EQ(say_seconds(0.31), "310 ms");
  EXPECT_EQ(say_seconds(12.345), "12.3 s");
  EXPECT_EQ(say_seconds(86400.4), "86400 s");
  EXPECT_EQ(say_seconds(2e-5), "20 us");
  EXPECT_EQ(say_seconds(0.0), "0 s");
  EXPECT_EQ(say_instant(812.4), "812.4 s");
  EXPECT_EQ(say_instant(100000.0), "100000 s");
  EXPECT_EQ(say_instant(-1e-5), "0 s");
  EXPECT_EQ(say_count(1, "sample"), "1 sample");
  EXPECT_EQ(say_count(2, "gap"), "2 gaps");
  EXPECT_EQ(said_count(2, "gap").text(), "2 gaps");
  EXPECT_EQ(said_count(1, "gap").pattern, "{} gap");
  EXPECT_EQ(say_value(293.15, Unit::parse("degC")), "20 degC");
  EXPECT_EQ(say_value(0.5, Unit{}), "0.5");
  EXPECT_EQ(say_difference(1.23456, Unit::parse("degC")), "1.23 degC");
}

}  // namespace
}  // namespace tumble
