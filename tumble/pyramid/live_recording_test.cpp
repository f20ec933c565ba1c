#include "tumble/pyramid/live_recording.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/pyramid/live_samples.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr std::uint64_t no_limit = 0;

/// What was given to LiveSamples, channel by channel.
struct Truth {
  std::vector<double> times, values;
};

/// Noise with spikes and missing samples, several samples at one arrival, hours between some.
Truth awkward_arrivals(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Truth truth;
  double time = 5.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (random() % 3 == 0) time += 1e-3 * static_cast<double>(random() % 10);
    if (random() % 5000 == 0) time += 3600.0;
    truth.times.push_back(time);
    const bool missing = random() % 97 == 0, spike = random() % 1000 == 0;
    truth.values.push_back(missing ? std::nan("") : 9.8 + 1e-7 * normal(random) + (spike ? 1e3 * normal(random) : 0.0));
  }
  return truth;
}

void expect_live_inside(const Pyramid& pyramid, std::size_t channel, const Truth& truth, double from, double to,
                        std::size_t pixels) {
  const std::size_t count = pyramid.channels()[channel].samples;
  const ChannelView view = pyramid.view(channel, from, to, pixels, pyramid.channels()[channel].unit);
  const std::size_t bars = view.samples ? view.values.size() : view.low.size();
  ASSERT_EQ(view.times.size(), bars);
  EXPECT_LE(bars, 2 * pixels + 4);
  for (std::size_t k = 0; k < bars; ++k) {
    const std::size_t first = view.first + k * view.block, end = std::min(first + view.block, count);
    ASSERT_LT(first, end);
    EXPECT_EQ(view.times[k], truth.times[first]);
    bool missing = false;
    for (std::size_t i = first; i < end; ++i) {
      const double value = truth.values[i];
      missing = missing || std::isnan(value);
      if (view.samples) {
        EXPECT_TRUE(std::isnan(value) ? std::isnan(view.values[k]) : value == view.values[k]);
      } else if (!std::isnan(value)) {
        ASSERT_LE(view.offset + static_cast<double>(view.low[k]), value) << "sample " << i;
        ASSERT_GE(view.offset + static_cast<double>(view.high[k]), value) << "sample " << i;
      }
    }
    EXPECT_TRUE(view.samples || ((view.flags[k] & ChannelView::missing) != 0) == missing);
  }
}

void expect_live_statistics(const Pyramid& pyramid, std::size_t channel, const Truth& truth, std::size_t first,
                            std::size_t end) {
  const SpanStatistics quick = pyramid.statistics(channel, first, end);
  long double sum = 0, squares = 0, count = 0;
  for (std::size_t i = first; i < end; ++i)
    if (!std::isnan(truth.values[i])) sum += truth.values[i], count += 1;
  for (std::size_t i = first; i < end; ++i)
    if (!std::isnan(truth.values[i])) squares += (truth.values[i] - sum / count) * (truth.values[i] - sum / count);
  if (count < 2) return;
  const auto sd = static_cast<double>(std::sqrt(squares / (count - 1)));
  EXPECT_EQ(quick.missing, end - first - static_cast<std::size_t>(count));
  EXPECT_NEAR(quick.mean, static_cast<double>(sum / count), 1e-12 * (9.8 + sd));
  EXPECT_NEAR(quick.sd, sd, 1e-12 * sd + 1e-15 * 9.8);
}

/// Random spans of everything that is there.
void expect_all_inside(const Pyramid& pyramid, std::size_t channel, const Truth& truth, std::mt19937_64& random) {
  const std::size_t count = pyramid.channels()[channel].samples;
  ASSERT_LE(count, truth.values.size());
  if (count == 0) return;
  EXPECT_EQ(pyramid.channels()[channel].first, truth.times.front());
  EXPECT_EQ(pyramid.channels()[channel].last, truth.times[count - 1]);
  expect_live_inside(pyramid, channel, truth, -1.0, 1e9, 1 + random() % 500);
  for (int trial = 0; trial < 6; ++trial) {
    std::size_t first = random() % count, end = random() % count;
    if (first > end) std::swap(first, end);
    expect_live_inside(pyramid, channel, truth, truth.times[first], truth.times[end], 1 + random() % 500);
    expect_live_statistics(pyramid, channel, truth, first, end);
    const auto at =
        static_cast<std::size_t>(std::ranges::lower_bound(truth.times, truth.times[first]) - truth.times.begin());
    EXPECT_EQ(pyramid.index_at(channel, truth.times[first]), at);
  }
}

TEST(LiveRecording, EverySampleLiesInsideOfItsBarWhileItGrows) {
  const ScratchFolder folder;
  const std::string path = folder.file("live.samples");
  constexpr std::size_t count = 400000;
  const Truth fast = awkward_arrivals(count, 1), slow = awkward_arrivals(count / 100, 2);
  std::atomic<bool> open = false;
  std::thread run([&] {
    LiveSamples samples(path, no_limit);
    const Unit unit = Unit::parse("m/s^2");
    const std::size_t x = samples.add({"acc.x", "", unit}), z = samples.add({"acc.z", "", unit}),
                      t = samples.add({"slow", "", unit});
    open = true;
    for (std::size_t i = 0; i < count; ++i) {
      samples.sample(x, fast.times[i], fast.values[i]);
      samples.sample(z, fast.times[i], fast.values[i]);
      if (i % 100 == 0) samples.sample(t, slow.times[i / 100], slow.values[i / 100]);
      if (i % 10000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
  });
  while (!open) std::this_thread::yield();
  LiveRecording live(path);
  std::mt19937_64 random(3);
  std::size_t seen = 0, looks = 0;
  std::shared_ptr<const Pyramid> earlier;
  for (bool going_on = true; going_on;) {
    const auto state = live.look();
    going_on = state.going_on || state.behind;
    if (state.pyramid->channels().size() < 3 || state.pyramid->channels()[0].samples == seen) continue;
    seen = state.pyramid->channels()[0].samples;
    ++looks;
    for (const std::size_t channel : {0u, 1u}) expect_all_inside(*state.pyramid, channel, fast, random);
    expect_all_inside(*state.pyramid, 2, slow, random);
    if (earlier) expect_all_inside(*earlier, 0, fast, random);  // a view of before does not change
    earlier = state.pyramid;
  }
  run.join();
  const auto state = live.look();
  EXPECT_EQ(state.pyramid->channels()[0].samples, count);
  EXPECT_EQ(state.pyramid->channels()[2].samples, count / 100);
  EXPECT_GE(looks, 3u);
}

// Blocks of every length, so that each look finds another number of samples behind the last whole block.
TEST(LiveRecording, EveryLengthHasItsBars) {
  const ScratchFolder folder;
  const Truth truth = awkward_arrivals(40000, 4);
  std::mt19937_64 random(5);
  std::unique_ptr<LiveRecording> live;
  for (std::size_t given = 0; given < truth.values.size();) {
    {
      LiveSamples samples(folder.file("a.samples"), no_limit);  // and gone on with each time
      const std::size_t channel = samples.add({"acc.z", "", Unit::parse("m/s^2")});
      for (std::size_t n = 1 + random() % (random() % 2 ? 70 : 3000); n > 0 && given < truth.values.size();
           --n, ++given)
        samples.sample(channel, truth.times[given], truth.values[given]);
    }
    if (!live) live = std::make_unique<LiveRecording>(folder.file("a.samples"));
    const auto state = live->look();
    ASSERT_EQ(state.pyramid->channels().size(), 1u);
    ASSERT_EQ(state.pyramid->channels()[0].samples, given);
    EXPECT_FALSE(state.going_on);
    expect_all_inside(*state.pyramid, 0, truth, random);
  }
}

TEST(LiveRecording, InfiniteSamplesAreMissingAndAClockNeverRunsBackwards) {
  const ScratchFolder folder;
  {
    LiveSamples samples(folder.file("a.samples"), no_limit);
    const std::size_t channel = samples.add({"gyro", "", Unit::parse("rad/s"), 100.0});
    for (const auto& [time, value] : {std::pair(1.0, 2.0), {3.0, HUGE_VAL}, {2.0, -HUGE_VAL}, {4.0, 5.0}})
      samples.sample(channel, time, value);
    samples.begin_mark("static", 1, 1.0);
    samples.end_mark(3.0);
    samples.fact("target", "../gyro.h5");
  }
  const auto state = LiveRecording(folder.file("a.samples")).look();
  const SpanStatistics all = state.pyramid->statistics(0, 0, 4);
  EXPECT_EQ(all.missing, 2u);
  EXPECT_EQ(all.minimum, 200.0);
  EXPECT_EQ(all.maximum, 500.0);
  EXPECT_EQ(state.pyramid->time(0, 2), 3.0);
  EXPECT_EQ(state.target, "../gyro.h5");
  ASSERT_EQ(state.pyramid->header().marks.size(), 1u);
  EXPECT_EQ(state.pyramid->header().marks[0].end, 3.0);
}

// A power cut may leave a half record; what comes later is put behind the last whole one.
TEST(LiveRecording, AHalfRecordAtTheEndWaits) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.samples");
  const auto give = [&](double from) {
    LiveSamples samples(path, no_limit);
    const std::size_t channel = samples.add({"gyro", "", Unit::parse("rad/s")});
    for (int i = 0; i < 100; ++i) samples.sample(channel, from + i, from);
  };
  give(0.0);
  const auto whole = std::filesystem::file_size(path);
  give(1000.0);
  std::filesystem::resize_file(path, whole + 500);
  LiveRecording live(path);
  EXPECT_EQ(live.look().pyramid->channels()[0].samples, 100u);
  give(2000.0);
  const auto pyramid = live.look().pyramid;
  EXPECT_EQ(pyramid->channels()[0].samples, 200u);
  EXPECT_EQ(pyramid->channels()[0].last, 2099.0);
}

TEST(LiveRecording, ADamagedFileIsRefused) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.samples");
  {
    LiveSamples samples(path, no_limit);
    const std::size_t channel = samples.add({"gyro", "", Unit::parse("rad/s")});
    for (int i = 0; i < 1000; ++i) samples.sample(channel, i, i);
  }
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 300; ++trial) {
    std::string changed = bytes;
    changed[random() % (trial % 2 ? 200 : changed.size())] = static_cast<char>(random());
    std::ofstream(path, std::ios::binary) << changed;
    try {
      const auto state = LiveRecording(path).look();
      for (std::size_t c = 0; c < state.pyramid->channels().size(); ++c) state.pyramid->statistics(c, 0, 1u << 20);
    } catch (const Error&) {
    }
  }
  std::ofstream(path, std::ios::binary) << "something else";
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {path}, .pattern = "does not hold the samples of a run"},
                      [&] { LiveRecording{path}; }));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {folder.file("none")}, .pattern = "cannot be read"},
                      [&] { LiveRecording{folder.file("none")}; }));
}

TEST(LiveRecording, WithoutRoomNothingIsWrittenAndNobodyWaits) {
  const ScratchFolder folder;
  LiveSamples samples(folder.file("a.samples"), std::numeric_limits<std::uint64_t>::max());
  const std::size_t channel = samples.add({"gyro", "", Unit::parse("rad/s")});
  for (int i = 0; i < 100 && samples.goes_on(); ++i) {
    samples.sample(channel, i, i);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_FALSE(samples.goes_on());
  EXPECT_EQ(std::filesystem::file_size(folder.file("a.samples")), 8u);
  LiveSamples nowhere(folder.file("no/such/folder"), no_limit);
  EXPECT_FALSE(nowhere.goes_on());
}

}  // namespace
}  // namespace tumble
