// What a model has room for and no method finds yet: made-up results with terms over other channels, lags, time, the
// instrument's own angle and a play, and an output with a delay.
#include <gtest/gtest.h>

#include <cmath>

#include "tumble/reduce/compensate.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr double rate = 100.0;  ///< [Hz]
constexpr std::size_t samples = 400;
// A solution is within 1e-12 of what is measured, here 1 rad/s or 1 rad; ten of them.
constexpr double rounding = 1e-11;

Channel channel_of(const std::string& name, QuantityKind kind, const char* unit, double (*value)(double time)) {
  Channel channel{name, kind, Unit::parse(unit), {0.0, rate, nullptr}, {}};
  for (std::size_t i = 0; i < samples; ++i) channel.values.push_back(value(static_cast<double>(i) / rate));
  return channel;
}

/// A result with these parameters [SI] and one model without terms.
Estimate result(const std::vector<double>& values, const std::string& role, Input shows, const char* unit) {
  Estimate estimate;
  for (const double value : values)
    estimate.parameters.push_back({"p" + std::to_string(estimate.parameters.size()), "p", Unit(), value, ""});
  estimate.covariance = Matrix(values.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) estimate.covariance(i, i) = 1e-8;
  OutputModel model{.role = role, .shows = shows, .unit = Unit::parse(unit)};
  model.recorded = model.unit;
  estimate.models = {model};
  return estimate;
}

void add_term(Estimate& estimate, std::size_t parameter, const Regressor& regressor) {
  estimate.models[0].terms.push_back({estimate.parameters[parameter].name, parameter, regressor.products(), -1e3, 1e3});
}

double turning(double t) { return std::sin(3.0 * t); }
double pressure(double t) { return 2.0 + std::cos(5.0 * t); }

/// The gyro shows u and these errors [rad/s].
Recording shown(const std::vector<double>& errors, std::vector<Channel> beside = {}) {
  Recording recording;
  recording.channels = {channel_of("gyro", QuantityKind::angular_rate, "rad/s", turning)};
  for (std::size_t i = 0; i < samples; ++i) recording.channels[0].values[i] += errors[i];
  for (Channel& channel : beside) recording.channels.push_back(std::move(channel));
  return recording;
}

void expect_turning(const Recording& recording, std::size_t from = 0) {
  for (std::size_t i = from; i < samples; ++i)
    EXPECT_NEAR(recording.channels[0].values[i], turning(static_cast<double>(i) / rate), rounding) << i;
}

std::vector<double> over_time(const std::function<double(double time)>& error) {
  std::vector<double> all;
  for (std::size_t i = 0; i < samples; ++i) all.push_back(error(static_cast<double>(i) / rate));
  return all;
}

TEST(MadeUpModel, ATermDependsOnAnotherChannel) {
  Estimate estimate = result({0.01}, "gyro", Input::rate_x, "rad/s");
  add_term(estimate, 0, TermFactor{.input = Input::channel, .role = "pressure"});
  const auto done = compensate(estimate, shown(over_time([](double t) { return 0.01 * pressure(t); }),
                                               {channel_of("pressure", QuantityKind::other, "1", pressure)}));
  expect_turning(done.recording);
  EXPECT_EQ(std::get<std::string>(done.tables[1].rows[0][4]), "channel pressure");
}

TEST(MadeUpModel, ATermWhoseChannelIsMissingRemainsByItsRole) {
  Estimate estimate = result({0.01, 0.0}, "gyro", Input::rate_x, "rad/s");
  add_term(estimate, 0, TermFactor{.input = Input::channel, .role = "pressure"});
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "every term of the error model"}, [&] {
    compensate(estimate, shown(std::vector<double>(samples, 0.0)));
  })) << "there is no other term";
  add_term(estimate, 1, Regressor(1.0));
  const auto done = compensate(estimate, shown(std::vector<double>(samples, 0.0)));
  ASSERT_FALSE(done.findings.empty());
  EXPECT_EQ(done.findings[0].code, "terms_remain");
  EXPECT_EQ(std::get<std::string>(done.findings[0].values[0].value), "pressure: p0");
}

TEST(MadeUpModel, ATermDependsOnALaggedChannelWhoseLagIsAParameter) {
  const double lag = 0.2;
  Estimate estimate = result({0.01, lag}, "gyro", Input::rate_x, "rad/s");
  add_term(estimate, 0, TermFactor{.input = Input::channel, .role = "pressure", .lag = 1});
  double felt = pressure(0.0);  // a first-order lag that begins at rest, sample by sample
  std::vector<double> errors;
  for (std::size_t i = 0; i < samples; ++i) {
    if (i > 0) felt += (1.0 - std::exp(-1.0 / rate / lag)) * (pressure(static_cast<double>(i) / rate) - felt);
    errors.push_back(0.01 * felt);
  }
  const auto done = compensate(estimate, shown(errors, {channel_of("pressure", QuantityKind::other, "1", pressure)}));
  expect_turning(done.recording);
}

TEST(MadeUpModel, ATermDependsOnTheTimeSincePowerOn) {
  Estimate estimate = result({0.02, 0.003}, "gyro", Input::rate_x, "rad/s");
  add_term(estimate, 0, decay(Input::since_power_on, 1.5));
  add_term(estimate, 1, Input::since_power_on);
  const double half = 0.5 / rate;  // what is felt is that at the middle of a sample
  const auto done = compensate(
      estimate, shown(over_time([&](double t) { return 0.02 * std::exp(-(t + half) / 1.5) + 0.003 * (t + half); })));
  expect_turning(done.recording);
}

TEST(MadeUpModel, ATermDependsOnTheInstrumentsOwnAngle) {
  Estimate estimate = result({0.01, -0.004}, "encoder", Input::angle, "rad");
  add_term(estimate, 0, TermFactor{.input = Input::angle, .form = TermFactor::Form::sine, .order = 1});
  add_term(estimate, 1, TermFactor{.input = Input::angle, .form = TermFactor::Form::cosine, .order = 8});
  Recording recording;
  recording.channels = {channel_of("encoder", QuantityKind::angle, "rad", turning)};
  for (double& value : recording.channels[0].values)
    value += 0.01 * std::sin(value) - 0.004 * std::cos(8.0 * value);  // of the true angle
  expect_turning(compensate(estimate, recording).recording);
}

TEST(MadeUpModel, ATermGoesThroughTheRecordAsAPlay) {
  const double width = 0.3;
  Estimate estimate = result({0.05}, "gyro", Input::rate_x, "rad/s");
  add_term(estimate, 0, TermFactor{.input = Input::rate_x, .form = TermFactor::Form::play, .size = width});
  double state = turning(0.0);
  std::vector<double> errors;
  bool lagged = false;
  for (std::size_t i = 0; i < samples; ++i) {
    const double u = turning(static_cast<double>(i) / rate);
    state = std::max(u - width, std::min(u + width, state));
    lagged = lagged || std::abs(state - u) > 0.9 * width;
    errors.push_back(0.05 * state);
  }
  EXPECT_TRUE(lagged);
  expect_turning(compensate(estimate, shown(errors)).recording);
}

TEST(MadeUpModel, AnOutputHasADelay) {
  Estimate estimate = result({0.01, 0.05}, "gyro", Input::rate_x, "rad/s");  // five samples
  add_term(estimate, 0, 1.0);
  estimate.models[0].delay = 1;
  Recording recording;
  recording.channels = {
      channel_of("gyro", QuantityKind::angular_rate, "rad/s", [](double t) { return turning(t - 0.05) + 0.01; })};
  const auto done = compensate(estimate, recording);
  const auto& values = done.recording.channels[0].values;
  for (std::size_t i = 0; i + 5 < samples; ++i)
    EXPECT_NEAR(values[i], turning(static_cast<double>(i) / rate), rounding) << i;
  EXPECT_TRUE(std::isnan(values.back()));  // nothing was recorded later
}

TEST(MadeUpModel, ATermMayAddToTheOutputWithoutTheScaleFactor) {
  Estimate estimate = result({2.0, 0.03}, "gyro", Input::rate_x, "rad/s");
  estimate.models[0].scale = 0;
  add_term(estimate, 1, TermFactor{.input = Input::channel, .role = "pressure"});
  estimate.models[0].terms[0].per_output = true;
  Recording recording =
      shown(std::vector<double>(samples, 0.0), {channel_of("pressure", QuantityKind::other, "1", pressure)});
  for (std::size_t i = 0; i < samples; ++i)
    recording.channels[0].values[i] = 2.0 * recording.channels[0].values[i] + 0.03 * recording.channels[1].values[i];
  const auto done = compensate(estimate, recording);
  expect_turning(done.recording);
  // u = (y - c x)/K: the variances 1e-8 of K and c with du/dK = -u/K, du/dc = -x/K
  const double x = pressure(0.5), u = turning(0.5);
  EXPECT_NEAR(find_channel(done.recording, "gyro.compensation_sd")->values[50], 1e-4 * std::hypot(u / 2.0, x / 2.0),
              1e-12);
}

}  // namespace
}  // namespace tumble
