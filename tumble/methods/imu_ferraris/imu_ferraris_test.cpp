#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/methods/imu_ferraris/closed_form.hpp"
#include "tumble/methods/imu_ferraris/sections.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"

namespace tumble {
namespace {

using imu_ferraris::labels;

const Method& method() { return find_method("imu_ferraris"); }

constexpr double g = 9.81;

/// The nine sections of a unit without errors, 2 s each at 50 Hz, with a little noise.
struct Session {
  std::map<std::string, std::array<double, 6>> truth;  ///< [m/s^2, rad/s] by section
  double turn_time = 2.0;

  Session() {
    for (std::size_t p = 0; p < 6; ++p) {
      truth[labels()[p]] = {};
      truth[labels()[p]][p / 2] = p % 2 == 0 ? g : -g;
    }
    for (std::size_t t = 0; t < 3; ++t) {
      truth[labels()[6 + t]] = {};
      truth[labels()[6 + t]][t] = g;
      truth[labels()[6 + t]][3 + t] = std::numbers::pi;  // 360 deg in 2 s
    }
  }

  Evidence evidence(const std::vector<Given>& given = {}, bool gyros = true) const {
    constexpr double rate = 50.0;
    Evidence out;
    std::vector<std::string> problems;
    auto all = given;
    all.push_back({"gravity", "9.81 m/s^2", "--set", true, true});
    out.plan.method = "imu_ferraris";
    out.plan.settings = resolve(method().options(), all, "", problems);
    EXPECT_TRUE(problems.empty());
    Recording recording;
    const char* names[]{"accelerometer_x", "accelerometer_y", "accelerometer_z", "gyro_x", "gyro_y", "gyro_z"};
    const RandomStream noise(7);
    for (std::size_t k = 0; k < (gyros ? 6u : 3u); ++k)
      recording.channels.push_back({names[k],
                                    k < 3 ? QuantityKind::specific_force : QuantityKind::angular_rate,
                                    Unit::parse(k < 3 ? "m/s^2" : "rad/s"),
                                    {0.0, rate, nullptr},
                                    {}});
    double begin = 0.0;
    for (const auto& [label, values] : truth) {
      recording.marks.push_back({label, begin, 1});
      begin += 2.0;
      for (std::size_t k = 0; k < recording.channels.size(); ++k) {
        auto& channel = recording.channels[k].values;
        for (std::size_t i = 0; i < 100; ++i)
          channel.push_back(values[k] + 1e-3 * noise.split(k).normal(channel.size()));
      }
    }
    out.recordings = {recording};
    return out;
  }
};

Estimate identified(const Evidence& evidence) { return method().identify(evidence, {}); }

TEST(ImuFerraris, FindsAUnitWithoutErrors) {
  const auto estimate = identified(Session().evidence());
  EXPECT_EQ(estimate.parameters.size(), 33u);
  // noise of 1e-3 m/s^2 and rad/s over 100 samples, and what is in the budget: four standard uncertainties
  for (const auto& parameter : estimate.parameters) {
    const double expected = parameter.name.ends_with("scale_factor") ? 1.0 : 0.0;
    const auto i = static_cast<std::size_t>(&parameter - estimate.parameters.data());
    EXPECT_NEAR(parameter.value, expected, 4.0 * standard_uncertainty(estimate, i) + 1e-12) << parameter.name;
  }
}

TEST(ImuFerraris, AccelerometersAlone) {
  auto session = Session();
  EXPECT_EQ(identified(session.evidence({}, false)).parameters.size(), 12u);
  for (std::size_t t = 6; t < 9; ++t) session.truth.erase(labels()[t]);
  const auto estimate = identified(session.evidence());
  EXPECT_EQ(estimate.parameters.size(), 12u);
  EXPECT_NE(std::ranges::find(estimate.findings, "no_known_turns", &Finding::code), estimate.findings.end());
}

TEST(ImuFerraris, NamesTheSectionsThatAreMissing) {
  Session session;
  session.truth.erase("y_a");
  session.truth["y_b"] = session.truth["x_p"];
  session.truth.erase("z_rot");
  const auto message = refusal(method(), session.evidence());
  EXPECT_NE(message.find("no section y_a, z_rot"), std::string::npos) << message;
  EXPECT_NE(message.find("other labels are y_b"), std::string::npos) << message;
  session.truth["turn"] = Session().truth["z_rot"];
  EXPECT_EQ(
      identified(session.evidence(
                     {{"labels", "y_a=y_b, z_rot = turn", "", true, true}, {"axes", "any", "", true, true}}, false))
          .parameters.size(),
      12u);
}

TEST(ImuFerraris, TakesTheLabelsOfImucal) {
  Session session;
  std::map<std::string, std::array<double, 6>> renamed;
  for (const auto& [label, values] : session.truth)
    renamed[(label.ends_with("rot") ? "gyr_" : "acc_") + label] = values;
  session.truth = renamed;
  EXPECT_EQ(identified(session.evidence()).parameters.size(), 33u);
}

/// Each of them is refused by name, and with axes = any taken for a mounting where it can be one.
TEST(ImuFerraris, NamesExchangedAndReversedAxes) {
  Session session;
  for (auto& [label, v] : session.truth) std::swap(v[0], v[1]);
  EXPECT_NE(refusal(method(), session.evidence()).find("accelerometer_x and accelerometer_y look exchanged"),
            std::string::npos);
  session = {};
  std::swap(session.truth["z_p"], session.truth["z_a"]);
  auto message = refusal(method(), session.evidence());
  EXPECT_NE(message.find("accelerometer_z is reversed"), std::string::npos) << message;
  EXPECT_NE(message.find("left-handed"), std::string::npos) << message;
  EXPECT_NE(message.find("labels of the sections may also be exchanged"), std::string::npos) << message;
  EXPECT_NO_THROW(identified(session.evidence({{"axes", "any", "", true, true}})));
  session = {};
  for (std::size_t p = 0; p < 6; ++p)
    for (std::size_t k = 0; k < 3; ++k) session.truth[labels()[p]][k] *= -1.0;
  EXPECT_NE(refusal(method(), session.evidence()).find("sign of gravity"), std::string::npos);
}

/// Poses about different axes leave nothing to solve; before, two outputs were said to be the same.
TEST(ImuFerraris, NamesLabelsOfPosesThatAreExchanged) {
  Session session;
  std::swap(session.truth["x_p"], session.truth["y_p"]);
  auto message = refusal(method(), session.evidence());
  EXPECT_NE(message.find("labels of poses look exchanged: by the accelerometers x_p is y_p, y_p is x_p"),
            std::string::npos)
      << message;
  session = {};
  std::swap(session.truth["z_a"], session.truth["y_p"]);
  message = refusal(method(), session.evidence());
  EXPECT_NE(message.find("y_p is z_a, z_a is y_p"), std::string::npos) << message;
}

/// Before, it was taken for reversed, or its turn for incomplete.
TEST(ImuFerraris, NamesAnOutputThatIsSilent) {
  for (const std::size_t k : {0u, 4u}) {
    auto evidence = Session().evidence();
    auto& channel = evidence.recordings[0].channels[k];
    std::ranges::fill(channel.values, 0.01);
    const auto message = refusal(method(), evidence);
    EXPECT_NE(message.find("'" + channel.name + "' holds the same value throughout"), std::string::npos) << message;
  }
}

TEST(ImuFerraris, NamesTurnsThatAreWrong) {
  Session session;
  session.truth["y_rot"][4] *= 0.75;
  const auto message = refusal(method(), session.evidence());
  EXPECT_NE(message.find("in y_rot the gyros show 0.75 of"), std::string::npos) << message;
  EXPECT_NE(message.find("by 270 deg and not by 360 deg"), std::string::npos) << message;
  session = {};
  session.truth["x_rot"][3] *= -1.0;
  EXPECT_NE(refusal(method(), session.evidence()).find("gyro_x is reversed"), std::string::npos);
  EXPECT_NE(refusal(method(), Session().evidence({{"rotation_angle", "-360 deg", "", true, true}}))
                .find("made in the other direction"),
            std::string::npos);
}

TEST(ImuFerraris, NamesUnitsTakenForOthers) {
  Session session;
  for (auto& [label, v] : session.truth)
    for (std::size_t k = 0; k < 6; ++k) v[k] *= k < 3 ? 1.0 / 9.80665 : 180.0 / std::numbers::pi;
  const auto message = refusal(method(), session.evidence());
  EXPECT_NE(message.find("values in g are read as m/s^2"), std::string::npos) << message;
  EXPECT_NE(message.find("values in deg/s are read as rad/s"), std::string::npos) << message;
}

TEST(ImuFerraris, SaysWhichPoseWasNotStill) {
  auto evidence = Session().evidence();
  auto& recording = evidence.recordings[0];
  const auto mark = std::ranges::find(recording.marks, "y_p", &Mark::label);
  const auto first = index_at(recording.channels[2], mark->begin);
  for (std::size_t i = 0; i < 100; ++i) recording.channels[2].values[first + i] += 0.2 * static_cast<double>(i > 60);
  const auto estimate = identified(evidence);
  const auto finding = std::ranges::find(estimate.findings, "pose_not_at_rest", &Finding::code);
  ASSERT_NE(finding, estimate.findings.end());
  EXPECT_EQ(finding->where, "y_p");
}

TEST(ImuFerraris, StatedAlignmentIsComparedWithThePoses) {
  Session session;
  session.truth["x_p"][1] += 0.03 * g;  // 1.7 deg
  const auto estimate = identified(session.evidence({{"pose_sd", "0.1 deg", "", true, true}}));
  EXPECT_NE(std::ranges::find(estimate.findings, "pose_sd_too_small", &Finding::code), estimate.findings.end());
}

}  // namespace
}  // namespace tumble
