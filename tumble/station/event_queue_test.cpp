#include "tumble/station/conduct/event_queue.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace tumble {
namespace {

using conduct::EventQueue;

TEST(EventQueue, WhatIsPutInMeanwhileComesAfterwards) {
  EventQueue queue;
  std::vector<double> handled;
  const auto handle = [&](const RunEvent& event) {
    handled.push_back(event.time);
    if (event.time > 1.0) return;
    queue.put(Tick{}, event.time + 2.0);
    queue.drain([](const RunEvent&) { FAIL() << "an event is handled inside of another one"; });
    handled.push_back(-event.time);
  };
  queue.put(Tick{}, 1.0);
  queue.put(Tick{}, 2.0);
  queue.drain(handle);
  EXPECT_EQ(handled, (std::vector{1.0, -1.0, 2.0, 3.0}));
}

TEST(EventQueue, AnEventSaysWhetherOthersHaveArrived) {
  EventQueue queue;
  std::vector<bool> more;
  const auto handle = [&](const RunEvent& event) { more.push_back(event.more); };
  queue.expect(true);
  queue.put(Tick{}, 1.0);
  queue.drain(handle);
  EXPECT_TRUE(queue.is_unjudged());
  queue.expect(false);
  EXPECT_TRUE(queue.is_unjudged()) << "nobody has looked yet";
  queue.put(Tick{}, 2.0);
  queue.drain(handle);
  EXPECT_FALSE(queue.is_unjudged());
  EXPECT_EQ(more, (std::vector{true, false}));
}

}  // namespace
}  // namespace tumble
