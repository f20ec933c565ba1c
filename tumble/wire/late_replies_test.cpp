// Replies that come after their request was given up: no protocol of tables says which question a reply answers.
#include <gtest/gtest.h>

#include <deque>

#include "tumble/wire/controllers.hpp"
#include "tumble/wire/testing/conversation.hpp"

namespace tumble {
namespace {

using testing::is_accepted;

/// [rad] where axis 1, 2, 3 are.
double place_of(int axis) { return 0.1 * axis; }

/// A controller whose answers wait on the line until they are let through.
struct LateLine {
  const Controller& controller;
  ControllerDevice device{controller};
  ControllerHost host{controller};
  std::deque<std::string> waiting = {};
  testing::ControllerRandom random{7};

  void hear(const std::string& bytes) {
    for (const auto& request : device.feed(bytes)) {
      auto reply = testing::random_reply(controller, request, random);
      for (int axis = 1; axis <= static_cast<int>(controller.axes.size()); ++axis)
        reply.values["position." + std::to_string(axis)] = place_of(axis);
      if (reply.values.contains("position")) reply.values["position"] = place_of(std::max(request.axis, 1));
      device.answer(reply);
    }
    if (auto bytes_out = device.output(); !bytes_out.empty()) waiting.push_back(std::move(bytes_out));
  }
  void ask(ControllerVerb verb, int axis) {
    if (!host.idle()) host.give_up();
    hear(host.ask({verb, {}, axis}));
  }
  /// Everything arrives, and what the host sends then is answered. Returned: the readings that it accepted.
  std::vector<ControllerReply> deliver() {
    std::vector<ControllerReply> accepted;
    const auto take = [&](const std::string& bytes) {
      for (auto& reply : host.feed(bytes))
        if (is_accepted(reply)) accepted.push_back(std::move(reply));
      for (std::string more = host.next(); !more.empty(); more = host.next()) hear(more);
    };
    take("");
    for (; !waiting.empty(); waiting.pop_front()) take(std::string(waiting.front()));
    return accepted;
  }
};

template <class Test>
void for_each_table(Test test) {
  for (const auto& shipped : shipped_controllers()) {
    const bool has_axes = shipped.name == "acutrol_like";  // one by default
    const Controller controller = controller_of(
        shipped, has_axes ? std::map<std::string, std::string>{{"axes", "3"}} : std::map<std::string, std::string>{});
    const auto* read = controller.find(ControllerVerb::read);
    if (controller.axes.size() < 2 || !read || controller.is_modbus()) continue;
    SCOPED_TRACE(shipped.name);
    test(controller);
  }
}

TEST(LateReply, IsNoReadingOfAnotherAxis) {
  int tables = 0;
  for_each_table([&](const Controller& controller) {
    LateLine line{controller};
    line.ask(ControllerVerb::read, 1);
    line.ask(ControllerVerb::read, 2);  // that of axis 1 is still on its way
    auto accepted = line.deliver();
    if (accepted.empty() && line.host.waits_for_quiet()) {  // nothing more arrives
      line.host.line_is_clear();
      accepted = line.deliver();
    }
    ASSERT_EQ(accepted.size(), 1u);
    EXPECT_EQ(accepted[0].axis, 2);
    EXPECT_NEAR(accepted[0].values.at("position"), place_of(2), 1e-4);
    ++tables;
  });
  EXPECT_GE(tables, 5);
}

TEST(LateReply, ThatNeverComesIsNotWaitedForForLong) {
  for_each_table([&](const Controller& controller) {
    LateLine line{controller};
    line.ask(ControllerVerb::read, 1);
    line.waiting.clear();
    line.ask(ControllerVerb::read, 2);
    auto accepted = line.deliver();
    if (line.host.waits_for_quiet()) {
      EXPECT_TRUE(accepted.empty());
      line.host.line_is_clear();
      accepted = line.deliver();
    }
    ASSERT_EQ(accepted.size(), 1u);
    EXPECT_NEAR(accepted[0].values.at("position"), place_of(2), 1e-4);
  });
}

TEST(LateReply, AStopIsSentAtOnce) {
  for_each_table([&](const Controller& controller) {
    LateLine line{controller};
    ControllerHost fresh(controller);
    const std::string stop = fresh.ask({ControllerVerb::stop, {}, 2});
    line.ask(ControllerVerb::read, 1);
    line.host.give_up();
    EXPECT_EQ(line.host.ask({ControllerVerb::stop, {}, 2}), stop);
  });
}

TEST(LateReply, AlsoOfTheQuestionThatClearsTheLineIsNoReading) {
  for_each_table([&](const Controller& controller) {
    LateLine line{controller};
    line.ask(ControllerVerb::read, 1);
    line.ask(ControllerVerb::read, 2);
    line.ask(ControllerVerb::read, 3);
    line.ask(ControllerVerb::read, 2);
    auto accepted = line.deliver();
    if (accepted.empty() && line.host.waits_for_quiet()) {
      line.host.line_is_clear();
      accepted = line.deliver();
    }
    ASSERT_EQ(accepted.size(), 1u);
    EXPECT_NEAR(accepted[0].values.at("position"), place_of(2), 1e-4);
  });
}

}  // namespace
}  // namespace tumble
