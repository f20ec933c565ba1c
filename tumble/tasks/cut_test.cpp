#include "tumble/tasks/cut.hpp"

#include <gtest/gtest.h>

#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// Two channels of one clock and a slow one, with three segments.
Recording turned() {
  Recording recording;
  auto stamps = std::make_shared<std::vector<double>>();
  for (int i = 0; i < 200000; ++i) stamps->push_back(0.01 * i + (i % 3) * 1e-3);
  const Unit rate = Unit::parse("deg/s");
  Channel x{"x", QuantityKind::angular_rate, rate, {0.0, 0.0, stamps}, {}}, y = x;
  y.name = "y";
  Channel slow{"slow", QuantityKind::temperature, Unit::parse("degC"), {5.0, 2.0, nullptr}, {}};
  for (int i = 0; i < 200000; ++i) x.values.push_back(i), y.values.push_back(-i);
  for (int i = 0; i < 3000; ++i) slow.values.push_back(i);
  recording.channels = {x, y, slow};
  recording.marks = {{"a", 0.0, 1}, {"b", 500.0, 1}, {"c", 1000.0, 2}};
  return recording;
}

TEST(Cut, HasTheSamplesOfTheSpan) {
  const ScratchFolder folder;
  const Recording whole = turned();
  write_recording(whole, folder.file("a.h5"));
  cut(folder.file("a.h5"), folder.file("b.h5"), {}, {300.1, 900.0}, {});
  const Recording part = read_recording(folder.file("b.h5"), {}, {});
  ASSERT_EQ(part.channels.size(), 3u);
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> values, times;
    for (std::size_t i = 0; i < whole.channels[c].values.size(); ++i)
      if (const double time = whole.channels[c].time(i); time >= 300.1 && time <= 900.0)
        values.push_back(whole.channels[c].values[i]), times.push_back(time);
    ASSERT_EQ(part.channels[c].values.size(), values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      ASSERT_DOUBLE_EQ(part.channels[c].values[i], values[i]);
      ASSERT_NEAR(part.channels[c].time(i), times[i], 1e-9);
    }
  }
  ASSERT_EQ(part.marks.size(), 2u);
  EXPECT_EQ(part.marks[0].label, "a");
  EXPECT_EQ(part.marks[1].label, "b");
}

TEST(Cut, OfChosenChannelsOnly) {
  const ScratchFolder folder;
  write_recording(turned(), folder.file("a.h5"));
  ReadOptions options;
  options.only = {"y"};
  cut(folder.file("a.h5"), folder.file("b.h5"), options, {10.0, 20.0}, {});
  const Recording part = read_recording(folder.file("b.h5"), {}, {});
  ASSERT_EQ(part.channels.size(), 1u);
  EXPECT_EQ(part.channels[0].name, "y");
}

TEST(Cut, RefusesASpanWithoutSamples) {
  const ScratchFolder folder;
  write_recording(turned(), folder.file("a.h5"));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"9000", "9001"}}, [&] {
    cut(folder.file("a.h5"), folder.file("b.h5"), {}, {9000.0, 9001.0}, {});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "--from must be before --to"}, [&] {
    cut(folder.file("a.h5"), folder.file("b.h5"), {}, {2.0, 1.0}, {});
  }));
  EXPECT_EQ(folder.entries(), 1u);
}

}  // namespace
}  // namespace tumble
