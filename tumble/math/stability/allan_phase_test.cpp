#include "tumble/math/stability/allan_phase.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "tumble/math/interruption.hpp"
#include "tumble/math/threads.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace {

using tumble::integrate_rate;
using tumble::integrate_rate_once;

/// White noise beside a mean and a drift; every sample in `gaps` missing.
std::vector<double> recording(std::size_t samples, const std::vector<std::size_t>& gaps) {
  std::mt19937_64 generator(samples);
  std::normal_distribution<double> noise;
  std::vector<double> rate(samples);
  for (std::size_t n = 0; n < samples; ++n)
    rate[n] = 9.8 + noise(generator) + static_cast<double>(n) / static_cast<double>(samples);
  for (const std::size_t n : gaps) rate[n] = std::numeric_limits<double>::quiet_NaN();
  return rate;
}

// What lies between them is a straight line in the number of samples that are there: both are rounded to an epsilon of
// the greater, which is some thousands. The longest record is one that is written past the caches.
TEST(AllanPhase, ReadOnceIsThePhaseButForASlope) {
  for (const std::size_t samples : {5u, 1024u, 1500u, 65536u, 400001u, (1u << 22) + 77u}) {
    const auto rate = recording(
        samples, samples > 1000 ? std::vector<std::size_t>{0, 700, 701, samples - 2} : std::vector<std::size_t>{});
    const auto once = integrate_rate_once(rate, 1), twice = integrate_rate(rate, 1);
    ASSERT_EQ(once.values.size(), samples + 1);
    ASSERT_EQ(once.runs.size(), twice.runs.size());
    for (std::size_t r = 0; r < once.runs.size(); ++r) {
      EXPECT_EQ(once.runs[r].first, twice.runs[r].first);
      EXPECT_EQ(once.runs[r].last, twice.runs[r].last);
    }
    double present = 0.0;
    for (const double value : rate) present += std::isnan(value) ? 0.0 : 1.0;
    const double slope = (once.values.back() - twice.values.back()) / present;
    double before = 0.0, worst = 0.0, most = 0.0;
    for (std::size_t n = 0; n <= samples; ++n) {
      worst = std::max(worst, std::abs(once.values[n] - twice.values[n] - slope * before));
      most = std::max({most, std::abs(once.values[n]), std::abs(twice.values[n])});
      if (n < samples && !std::isnan(rate[n])) ++before;
    }
    EXPECT_LE(worst, 1e-12 * most) << samples;
  }
}

TEST(AllanPhase, RefusesWhatCannotBeIntegrated) {
  for (const auto integrate : {&integrate_rate, &integrate_rate_once}) {
    auto rate = recording(3000, {});
    EXPECT_TRUE(tumble::refuses(tumble::Error::Kind::bad_data, tumble::Asked{}, [&] { integrate(rate, 3001); }));
    rate[2345] = INFINITY;
    try {
      integrate(rate, 3);
      FAIL();
    } catch (const tumble::Error& error) {
      EXPECT_EQ(error.kind, tumble::Error::Kind::bad_data);
      EXPECT_NE(std::string(error.what()).find("sample 2345"), std::string::npos) << error.what();
    }
    EXPECT_TRUE(tumble::refuses(tumble::Error::Kind::bad_data, tumble::Asked{},
                                [&] { integrate(std::vector<double>(2000, std::nan("")), 1); }));
  }
}

// Pieces wait for those before them, which must not be those that were stopped.
TEST(AllanPhase, IsStoppedBetweenAnyTwoPieces) {
  const auto rate = recording(2'000'000, {});
  for (const std::size_t threads : {1u, 2u, 7u}) {
    tumble::limit_threads(threads);
    for (int stop = 0; stop < 30; ++stop) {
      int asked = 0;
      const tumble::Interruption interruption([&] {
        if (asked++ == stop % 4) throw std::runtime_error("enough");
      });
      try {
        integrate_rate_once(rate, 3);
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "enough");
      }
    }
  }
  tumble::limit_threads(0);
}

}  // namespace
