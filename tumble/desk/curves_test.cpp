#include "tumble/desk/desk_lines/curves.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tumble {
namespace {

RunView view_at(double time, double low, double high) {
  RunView view;
  view.time = time;
  RunView::ChannelView channel;
  channel.name = "gyro";
  channel.unit = Unit::parse("rad/s");
  channel.low = low;
  channel.high = high;
  view.channels = {channel};
  return view;
}

TEST(RunDeskCurves, EveryViewLiesInsideABarOfTheWholeRun) {
  desk_lines::Curves curves(16);
  for (int k = 1; k <= 1000; ++k) {
    curves.add(view_at(0.5 * k, -k % 97, k % 89));
    ASSERT_LE(curves.recent().size(), 16u);
    ASSERT_LE(curves.whole().size(), 17u);
  }
  const auto whole = curves.whole();
  EXPECT_EQ(whole.back().time, 500.0);
  std::size_t bar = 0;
  for (int k = 1; k <= 1000; ++k) {
    while (whole[bar].time < 0.5 * k) ++bar;
    EXPECT_LE(whole[bar].low[0], -k % 97);
    EXPECT_GE(whole[bar].high[0], k % 89);
  }
  EXPECT_EQ(curves.recent().front().time, 0.5 * 985);
}

TEST(RunDeskCurves, AViewWithoutSamplesIsAGap) {
  desk_lines::Curves curves(8);
  curves.add(view_at(1.0, std::nan(""), std::nan("")));
  EXPECT_TRUE(std::isnan(curves.recent().back().low[0]));
  curves.add(view_at(2.0, -1.0, 1.0));
  EXPECT_EQ(curves.whole().back().high[0], 1.0);
}

}  // namespace
}  // namespace tumble
