#include "tumble/methods/allan_noise/tables.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "tumble/units/unit.hpp"

namespace tumble::allan_noise {
namespace {

constexpr double sampling = 100.0;

std::string text(const Table& table, std::size_t row, std::size_t column) {
  return std::get<std::string>(table.rows.at(row).at(column));
}

/// The number that a cell starts with.
double number(const Table& table, std::size_t row, std::size_t column) { return std::stod(text(table, row, column)); }

FittedTerm term(NoiseTerm which, bool kept, double squared) {
  FittedTerm one;
  one.unit = {which, 0.0};
  one.kept = kept;
  one.squared = squared;
  one.squared_sd = 0.02 * squared;
  one.upper_limit = 4.0 * squared;
  one.degrees_of_freedom = 1e6;
  return one;
}

/// A gyro with N, B and K [SI] and a curve that is what is expected of them.
ChannelNoise gyro(double n, double b, double k) {
  ChannelNoise channel;
  channel.label = "gyro";
  channel.kind = QuantityKind::angular_rate;
  channel.rate = sampling;
  channel.samples = 360000;
  channel.fit.terms = {term(NoiseTerm::quantization, false, 1e-20), term(NoiseTerm::white, n > 0.0, n * n * sampling),
                       term(NoiseTerm::flicker, b > 0.0, b * b),
                       term(NoiseTerm::random_walk, k > 0.0, k * k / sampling)};
  channel.fit.covariance = Matrix(4, 4);
  channel.fit.model_error_variance.assign(4, 0.0);
  for (std::size_t t = 0; t < 4; ++t) channel.fit.covariance(t, t) = std::pow(channel.fit.terms[t].squared_sd, 2);
  take_values_of_terms(channel.fit);
  for (std::size_t m = 1; m <= 65536; m *= 2) {
    const double tau = static_cast<double>(m) / sampling;
    const double variance = n * n / tau + 2.0 * std::numbers::ln2 / std::numbers::pi * b * b + k * k * tau / 3.0;
    channel.curve.push_back({m, tau, std::sqrt(variance), 1, 0, 1.0, 0.0, 0.0});
  }
  return channel;
}

TEST(NoiseTables, ALineReadsATermAloneExactlyAndOthersWithIt) {
  const double n = si(0.1, "deg/sqrt(h)"), b = si(2.0, "deg/h"), k = si(30.0, "deg/h/sqrt(h)");
  const Table alone = readings_table({gyro(n, 0.0, 0.0)});
  ASSERT_EQ(alone.rows.size(), 1u);
  EXPECT_EQ(text(alone, 0, 2), "0.1 deg/sqrt(h)");
  EXPECT_EQ(text(alone, 0, 3), "0.1 deg/sqrt(h)");
  EXPECT_EQ(text(alone, 0, 5), "100 %");
  const Table all = readings_table({gyro(n, b, k)});
  ASSERT_EQ(all.rows.size(), 3u);
  EXPECT_EQ(text(all, 1, 1), "bias_instability");
  // The line takes the others' share too: reading squared times share is the term's square.
  for (std::size_t row = 0; row < 3; ++row)
    EXPECT_NEAR(std::pow(number(all, row, 3), 2) * number(all, row, 5) / 100.0 / std::pow(number(all, row, 2), 2), 1.0,
                0.03)  // shares are whole per cent
        << row;
  EXPECT_GT(number(all, 1, 3), 1.1 * number(all, 1, 2));
}

TEST(NoiseTables, DensitiesAreInTheUnitsOfTheirNames) {
  const double n = 1.888e-4, k = 2.557e-6;
  const Table table = densities_table({gyro(n, 0.0, k)});
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(text(table, 0, 1), "gyroscope_noise_density");
  EXPECT_EQ(text(table, 0, 2), "0.0001888");
  EXPECT_EQ(text(table, 0, 3), "1 %");  // half of that of the square
  EXPECT_EQ(text(table, 0, 4), "rad/s/sqrt(Hz)");
  EXPECT_EQ(text(table, 0, 5), "sd of one sample at 100 Hz: 0.001888 rad/s");
  EXPECT_EQ(text(table, 1, 1), "gyroscope_random_walk");
  EXPECT_EQ(text(table, 1, 2), "2.557e-06");
  EXPECT_EQ(text(table, 1, 4), "rad/s^2/sqrt(Hz)");
  // Not seen: the limit, twice the value tried here.
  ChannelNoise force = gyro(n, 0.0, k);
  force.kind = QuantityKind::specific_force;
  force.fit.terms[3].kept = false;
  take_values_of_terms(force.fit);
  const Table limit = densities_table({force});
  EXPECT_EQ(text(limit, 1, 1), "accelerometer_random_walk");
  EXPECT_EQ(text(limit, 1, 2), "< 5.11e-06");
  EXPECT_EQ(text(limit, 1, 3), "");
  EXPECT_EQ(text(limit, 1, 4), "m/s^3/sqrt(Hz)");
}

TEST(NoiseTables, CompositesNameTheirTerms) {
  ChannelNoise channel = gyro(1e-4, 0.0, 1e-6);
  for (int i = 0; i < 9; ++i) {
    NoiseComposite one;
    one.terms = {{NoiseTerm::white, 0.0}, {NoiseTerm::markov, 5000.0}};
    one.parameters = 3;
    one.aicc = 0.26 + i;
    one.supported = i < 2;
    channel.fit.composites.push_back(one);
  }
  const Table table = composites_table({channel, channel});
  ASSERT_EQ(table.rows.size(), 12u);  // six of each channel
  EXPECT_EQ(text(table, 0, 1), "N + Markov 50 s");
  EXPECT_EQ(std::get<double>(table.rows[0][2]), 3.0);
  EXPECT_DOUBLE_EQ(std::get<double>(table.rows[0][3]), 0.3);
  EXPECT_EQ(text(table, 1, 4), "yes");
  EXPECT_EQ(text(table, 2, 4), "no");
}

TEST(NoiseTables, AdviceSaysLengthsInTheUnitOneWould) {
  ChannelNoise channel = gyro(1e-4, 0.0, 0.0);
  channel.advice = {{"a", "1 %", "5 %", 5000.4},
                    {"b", "1 %", "5 %", 7.25},
                    {"c", "1 %", "5 %", 36000.0},
                    {"d", "1 %", "5 %", 1728000.0},
                    {"e", "1 %", "5 %", std::numeric_limits<double>::infinity()},
                    {"f", "1 %", "5 %", 0.0}};
  const Table table = advice_table({channel}, 0.05);
  EXPECT_NE(table.caption.find("5 %"), std::string::npos);
  const char* expected[] = {"5000 s", "7.25 s", "10 h", "20 days", "no length", ""};
  for (std::size_t row = 0; row < 6; ++row) EXPECT_EQ(text(table, row, 5), expected[row]);
  EXPECT_EQ(text(table, 0, 3), "3600 s");
}

}  // namespace
}  // namespace tumble::allan_noise
