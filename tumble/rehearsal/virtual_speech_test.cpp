#include "tumble/rehearsal/virtual_speech.hpp"

#include <gtest/gtest.h>

#include "tumble/units/constants.hpp"
#include "tumble/wire/controllers.hpp"

namespace tumble {
namespace {

/// Host and device of one declaration, without a line between them.
struct Talk {
  Controller controller = controller_of(find_controller("mn_three_axis"));
  ControllerHost host{controller};
  ControllerDevice device{controller};

  /// What the device makes of a request, axis by axis.
  std::vector<ControllerRequest> ask(ControllerVerb verb, std::map<std::string, double> values, int axis) {
    std::vector<ControllerRequest> meant;
    for (std::string bytes = host.ask({verb, std::move(values), axis}); !bytes.empty(); bytes = host.next()) {
      for (const auto& request : device.feed(bytes)) {
        meant = axis_by_axis(controller, request);
        device.answer({request.verb});
      }
      host.feed(device.output());
    }
    return meant;
  }
};

TEST(AxisByAxis, ALineOfAllAxesIsForThoseOfWhichItSaysSo) {
  Talk talk;
  const auto turns = talk.ask(ControllerVerb::rate, {{"rate", -10.0 * degree}}, 2);
  ASSERT_EQ(turns.size(), 1u);
  EXPECT_EQ(turns[0].verb, ControllerVerb::rate);
  EXPECT_EQ(turns[0].axis, 2);
  EXPECT_NEAR(turns[0].values.at("rate"), -10.0 * degree, 1e-9);
  const auto goes = talk.ask(ControllerVerb::position, {{"position", 90.0 * degree}}, 3);
  ASSERT_EQ(goes.size(), 1u) << "axis 2 has no new rate: it goes on";
  EXPECT_EQ(goes[0].verb, ControllerVerb::position);
  EXPECT_EQ(goes[0].axis, 3);
  const auto both = talk.ask(ControllerVerb::rate, {{"rate", 5.0 * degree}}, 1);
  ASSERT_EQ(both.size(), 2u) << "axis 2 is told its rate again";
  EXPECT_EQ(both[0].axis, 1);
  EXPECT_EQ(both[1].axis, 2);
  EXPECT_NEAR(both[1].values.at("rate"), -10.0 * degree, 1e-9);
}

TEST(AxisByAxis, AStopIsForAllAxesAndNoneBeginsAgain) {
  Talk talk;
  talk.ask(ControllerVerb::rate, {{"rate", 10.0 * degree}}, 2);
  const auto stops = talk.ask(ControllerVerb::stop, {}, 1);
  ASSERT_EQ(stops.size(), 3u);
  for (const auto& one : stops) EXPECT_EQ(one.verb, ControllerVerb::stop);
  const auto turns = talk.ask(ControllerVerb::rate, {{"rate", 5.0 * degree}}, 1);
  ASSERT_EQ(turns.size(), 1u) << "axis 2 was stopped";
  EXPECT_EQ(turns[0].axis, 1);
}

}  // namespace
}  // namespace tumble
