#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tumble/methods/testing/answer.hpp"

namespace tumble {
namespace {

/// Axis y of the dwell of 100 Hz on a shaker (tests/reference/endaq_vibration): at rest to 1 s and from 11 s, steady
/// from 4 s to 9 s.
Channel dwell() {
  Channel channel{"accelerometer", QuantityKind::specific_force, Unit::parse("g"), {0.0, 0.0, nullptr}, {}};
  std::ifstream file(TUMBLE_SOURCE_DIR "/tests/reference/endaq_vibration/SSX70065_y.csv");
  std::string line;
  std::getline(file, line);
  std::vector<double> stamps;
  double time, counts;
  char comma;
  while (file >> time >> comma >> counts) {
    stamps.push_back(time);
    channel.values.push_back(si(counts / 128.0, "g"));
  }
  channel.timeline.stamps = std::make_shared<const std::vector<double>>(std::move(stamps));
  return channel;
}

// As published: 10.196 g at 99.998 Hz by a four-parameter fit; both to half a unit of their last digit.
TEST(SineVibration, DwellOnARealShaker) {
  Channel channel = dwell();
  ASSERT_EQ(channel.values.size(), 21654u);
  const Method& method = find_method("sine_vibration");
  Plan plan;
  plan.method = method.name;
  plan.settings = defaults(method.options());
  plan.settings.set_word("samples", "instant");
  const auto add = [&](const char* label, double seconds, bool shaken) {
    Segment segment{label, seconds, 1, {}};
    if (shaken) segment.axes["shake"] = {.kind = Motion::Kind::sine, .amplitude = si(10.0, "g"), .frequency = 100.0};
    plan.schedule.push_back(segment);
  };
  add("before", 1.0, false), add("dwell", 5.0, true), add("after", 1.0, false);
  Recording recording;
  recording.channels.push_back(std::move(channel));
  recording.marks = {{"before", 0.0, 1}, {"dwell", 4.0, 1}, {"after", 11.0, 1}};
  const auto e = method.identify({plan, {recording}}, {});
  const Table* table = find_table(e, "response");
  ASSERT_EQ(table->rows.size(), 1u);
  const auto cell = [&](const char* name) {
    for (std::size_t c = 0; c < table->columns.size(); ++c)
      if (table->columns[c].name == name) return std::get<double>(table->rows[0][c]);
    return std::nan("");
  };
  const double amplitude = value(e, "gain_100Hz") * 10.0;
  EXPECT_NEAR(cell("frequency"), 99.998, 0.0006);
  EXPECT_NEAR(amplitude, 10.196, 0.0015);
  EXPECT_NEAR(cell("sd"), si(10.196 / std::sqrt(2.0), "g"), si(0.005, "g"));
  EXPECT_NEAR(cell("mean_shift"), si(0.015, "g"), si(0.002, "g"));
}

}  // namespace
}  // namespace tumble
