// A rig that answers late: in simulated time, every fifth reply stalls for longer than its deadline.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <random>

#include "tumble/station/conduct/device_line.hpp"
#include "tumble/wire/controllers.hpp"

namespace tumble {
namespace {

constexpr double answer_due = 0.25, link_is_lost = 0.5, tick = 0.001;  ///< [s]

/// Axis k stands at k rad, plus a thousandth of the time of the answer [s].
double told_at(int axis, double time) { return axis + 1e-3 * time; }

struct LateCounts {
  int good = 0, wrong_axis = 0, old = 0, overdue = 0;
};

LateCounts talk_to_late_rig(const std::string& name, const std::map<std::string, std::string>& settings,
                            double seconds) {
  const Controller controller = controller_of(find_controller(name), settings);
  ControllerDevice device(controller);
  std::deque<std::pair<double, std::string>> line;  // [s] when it arrives
  std::mt19937_64 random(5);
  double now = 0.0, asked_at = 0.0, busy_until = 0.0, heard = 0.0;
  int axis = 1;
  LateCounts counts;
  conduct::DeviceLine host(controller, [&](std::string_view bytes) {
    for (const auto& request : device.feed(bytes)) {
      ControllerReply reply{request.verb};
      reply.words = {{"identity", "late rig"}, {"state", "ready"}, {"moving", "no"}};
      for (int k = 1; k <= 3; ++k) {
        reply.values["position." + std::to_string(k)] = told_at(k, now);
        reply.values["rate." + std::to_string(k)] = 0.0;
      }
      reply.values["position"] = told_at(std::max(request.axis, 1), now);
      reply.values["rate"] = reply.values["status"] = 0.0;
      device.answer(reply);
    }
    if (auto reply = device.output(); !reply.empty()) {
      const bool stalls = random() % 5 == 0;
      busy_until = std::max(busy_until, now) + (stalls ? 0.28 : 0.005);  // nothing overtakes on a line
      line.emplace_back(busy_until, std::move(reply));
    }
  });
  bool waiting = false;
  const auto take = [&](const std::vector<ControllerReply>& replies) {
    for (const auto& reply : replies) {
      if (!reply.problem.empty() || reply.refused || reply.verb != ControllerVerb::read) continue;
      waiting = false;
      heard = now;
      const double position = reply.values.at("position");
      counts.good += std::abs(position - axis) < 0.5;
      counts.wrong_axis += std::abs(position - axis) >= 0.5;
      counts.old += (position - std::round(position)) * 1e3 < asked_at - 0.01;
    }
  };
  for (; now < seconds; now += tick) {
    while (!line.empty() && line.front().first <= now) {
      const std::string bytes = line.front().second;
      line.pop_front();
      take(host.receive(bytes, now));
    }
    take(host.at(now));
    if (waiting && now < asked_at + answer_due) continue;
    counts.overdue += waiting;
    if (waiting && now > heard + link_is_lost) {  // the run has ended; the next one has a new line
      host.restart();
      line.clear();
      busy_until = heard = now;
    }
    axis = axis % 3 + 1;
    asked_at = now;
    waiting = true;
    take(host.ask({ControllerVerb::read, {}, axis}, now));
  }
  return counts;
}

TEST(LateRig, NoReadingIsThatOfAnotherAxisOrAnotherTime) {
  const std::map<std::string, std::map<std::string, std::string>> tables{
      {"acutrol_like", {{"axes", "3"}}}, {"aerotech_ensemble", {}}, {"pi_gcs", {}}, {"newport_smc100", {}}};
  for (const auto& [name, settings] : tables) {
    SCOPED_TRACE(name);
    const LateCounts counts = talk_to_late_rig(name, settings, 300.0);
    EXPECT_EQ(counts.wrong_axis, 0);
    EXPECT_EQ(counts.old, 0);
    EXPECT_GT(counts.overdue, 100) << "the rig is late";
    EXPECT_GT(counts.good, 500) << "and the talk goes on";
  }
}

}  // namespace
}  // namespace tumble
