#include "tumble/pyramid/pyramid.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// A quiet accelerometer on 1 g, a gyro with spikes and missing samples, an output that is stuck, one that is empty.
Recording awkward(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  Recording recording;
  const Timeline even{-3.25, 400.0, nullptr};
  Channel acc{"acc.z", QuantityKind::specific_force, Unit::parse("m/s^2"), even, {}};
  Channel gyro{"gyro.x", QuantityKind::angular_rate, Unit::parse("deg/h"), even, {}};
  Channel stuck{"stuck", QuantityKind::count, Unit::parse("pulse"), even, {}};
  Channel missing{"missing", QuantityKind::temperature, Unit::parse("degC"), even, {}};
  for (std::size_t i = 0; i < count; ++i) {
    acc.values.push_back(9.8 + 1e-7 * normal(random) + 1e-9 * static_cast<double>(i));
    const double spike = uniform(random) < 1e-3 ? 1e4 * normal(random) : 0.0;
    gyro.values.push_back(uniform(random) < 0.01 ? none : 1e-5 * normal(random) + spike);
    stuck.values.push_back(7.0);
    missing.values.push_back(none);
  }
  recording.channels = {acc, gyro, stuck, missing};
  recording.marks = {{"static", 0.0, 1}, {"spin", 2.0, 1}};
  recording.instrument = "unit 7";
  return recording;
}

Recording stamped(std::size_t count, std::uint64_t seed) {
  Recording recording = awkward(count, seed);
  std::mt19937_64 random(seed + 1);
  std::exponential_distribution<double> step(100.0);
  auto stamps = std::make_shared<std::vector<double>>();
  double time = 1000.0;
  for (std::size_t i = 0; i < count; ++i) stamps->push_back(time += 1e-3 + step(random));
  for (Channel& channel : recording.channels) channel.timeline = {0.0, 0.0, stamps};
  recording.marks.clear();
  return recording;
}

struct Opened {
  ScratchFolder folder;
  Recording recording;
  std::unique_ptr<Pyramid> pyramid;

  Opened(const Recording& from, const std::string& name) {
    const std::string file = folder.file(name);
    write_recording(from, file);
    recording = read_recording(file, {}, {});
    build(file);
  }
  /// Of a file that is there.
  explicit Opened(const std::function<void(const std::string& path)>& write) {
    write(folder.file("a.h5"));
    recording = read_recording(folder.file("a.h5"), {}, {});
    build(folder.file("a.h5"));
  }

 private:
  void build(const std::string& file) {
    const std::string path = folder.file("a.pyr");
    EXPECT_EQ(build_pyramid(file, {}, path, {})(), sha256_of_file(file));
    pyramid = std::make_unique<Pyramid>(path, sample_reader(file, {}));
  }
};

/// Counts of a gyro in deflated chunks, as a logger writes them.
void write_counts(const std::string& path, std::size_t count, hsize_t chunk) {
  std::mt19937_64 random(count);
  std::vector<short> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<short>(random() % 8001 - 4000));
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t group = H5Gcreate2(file, "/channels", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const hsize_t size = count;
  const hsize_t most = H5S_UNLIMITED;
  const hid_t space = H5Screate_simple(1, &size, &most), plist = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(plist, 1, &chunk);
  H5Pset_shuffle(plist);
  H5Pset_deflate(plist, 3);
  const hid_t scalar = H5Screate(H5S_SCALAR), text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, 5);
  const double rate = 200.0;
  for (const auto& [name, type] : {std::pair("/channels/counts", H5T_STD_I16LE), {"/channels/wide", H5T_IEEE_F64LE}}) {
    const hid_t dataset = H5Dcreate2(file, name, type, space, H5P_DEFAULT, plist, H5P_DEFAULT);
    H5Dwrite(dataset, H5T_NATIVE_SHORT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    const hid_t hertz = H5Acreate2(dataset, "rate", H5T_IEEE_F64LE, scalar, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t unit = H5Acreate2(dataset, "unit", text, scalar, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(hertz, H5T_NATIVE_DOUBLE, &rate);
    H5Awrite(unit, text, "pulse");
    H5Aclose(hertz), H5Aclose(unit), H5Dclose(dataset);
  }
  H5Tclose(text), H5Sclose(scalar), H5Pclose(plist), H5Sclose(space), H5Gclose(group), H5Fclose(file);
}

/// Every sample of the view's bars lies inside of its bar, and every flag is true.
void expect_inside(const Pyramid& pyramid, const Channel& channel, std::size_t number, double from, double to,
                   std::size_t pixels, const Unit& unit) {
  const ChannelView view = pyramid.view(number, from, to, pixels, unit);
  const std::size_t bars = view.samples ? view.values.size() : view.low.size();
  ASSERT_GT(bars, 0u);
  EXPECT_LE(bars, 2 * pixels + 4);
  for (std::size_t k = 0; k < bars; ++k) {
    const std::size_t first = view.first + k * view.block;
    const std::size_t end = std::min(first + view.block, channel.values.size());
    ASSERT_LT(first, end);
    const double time = view.step > 0.0 ? view.start + static_cast<double>(k) * view.step : view.times[k];
    EXPECT_NEAR(time, channel.time(first), 1e-9);
    bool missing = false, constant = true;
    std::size_t present = 0;
    for (std::size_t i = first; i < end; ++i) {
      const double value = unit.from_si(channel.values[i]);
      if (view.samples) {
        EXPECT_TRUE(std::isnan(value) ? std::isnan(view.values[k]) : value == view.values[k]);
      } else if (std::isnan(value)) {
        missing = true;
      } else {
        ++present;
        ASSERT_LE(view.offset + static_cast<double>(view.low[k]), value) << channel.name << " sample " << i;
        ASSERT_GE(view.offset + static_cast<double>(view.high[k]), value) << channel.name << " sample " << i;
      }
    }
    if (view.samples) continue;
    const auto [least, most] = std::minmax_element(channel.values.begin() + static_cast<std::ptrdiff_t>(first),
                                                   channel.values.begin() + static_cast<std::ptrdiff_t>(end),
                                                   [](double a, double b) { return a < b; });
    constant = present > 1 && !missing && *least == *most;
    EXPECT_EQ((view.flags[k] & ChannelView::missing) != 0, missing);
    EXPECT_TRUE(!constant || (view.flags[k] & ChannelView::constant) != 0);
    EXPECT_EQ(present == 0, std::isnan(view.low[k]));
  }
}

void expect_views_hold(const Opened& opened, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform;
  const char* units[] = {"g", "rad/s", "pulse", "degC"};
  for (std::size_t c = 0; c < opened.recording.channels.size(); ++c) {
    const Channel& channel = opened.recording.channels[c];
    const double begin = channel.time(0), length = span(channel);
    for (int trial = 0; trial < 30; ++trial) {
      const double width = length * std::pow(10.0, -4.0 * uniform(random));
      const double from = begin + (length - width) * uniform(random);
      const std::size_t pixels = 1 + random() % 900;
      expect_inside(*opened.pyramid, channel, c, from, from + width, pixels, channel.unit);
      expect_inside(*opened.pyramid, channel, c, from, from + width, pixels, Unit::parse(units[c]));
    }
    expect_inside(*opened.pyramid, channel, c, begin - 10.0, begin + length + 10.0, 50, channel.unit);
  }
}

/// Directly, in two passes of extended precision.
SpanStatistics directly(const Channel& channel, std::size_t first, std::size_t end) {
  long double sum = 0, time = 0, count = 0;
  SpanStatistics result{end - first, 0, 0, 0, none, none, none, none, none};
  for (std::size_t i = first; i < end; ++i) {
    const double value = channel.values[i];
    if (std::isnan(value)) {
      ++result.missing;
      continue;
    }
    sum += value;
    time += channel.time(i);
    count += 1;
    result.minimum = std::fmin(result.minimum, value);
    result.maximum = std::fmax(result.maximum, value);
  }
  const long double mean = sum / count, middle = time / count;
  long double squares = 0, squares_time = 0, products = 0;
  for (std::size_t i = first; i < end; ++i) {
    if (std::isnan(channel.values[i])) continue;
    const long double value = channel.values[i] - mean, late = channel.time(i) - middle;
    squares += value * value;
    squares_time += late * late;
    products += value * late;
  }
  if (count > 0) result.mean = static_cast<double>(mean);
  if (count > 1) result.sd = static_cast<double>(std::sqrt(squares / (count - 1)));
  if (squares_time > 0) result.slope = static_cast<double>(products / squares_time);
  return result;
}

/// To 1e-12: mean, of its size; sd, relative; slope, of the slope that the scatter could make over the span, which is
/// what a rounding of each sample can change.
void expect_statistics_agree(const Opened& opened, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (std::size_t c = 0; c < 3; ++c) {
    const Channel& channel = opened.recording.channels[c];
    for (int trial = 0; trial < 60; ++trial) {
      const std::size_t count = channel.values.size();
      std::size_t first = random() % count, end = random() % count;
      if (trial == 0) first = 0, end = count;
      if (first > end) std::swap(first, end);
      if (trial % 3 == 1) end = std::min(count, first + 1 + random() % 100);
      if (end - first < 3) continue;
      const SpanStatistics quick = opened.pyramid->statistics(c, first, end), direct = directly(channel, first, end);
      EXPECT_EQ(quick.samples, end - first);
      EXPECT_EQ(quick.missing, direct.missing);
      EXPECT_EQ(quick.minimum, direct.minimum);
      EXPECT_EQ(quick.maximum, direct.maximum);
      EXPECT_NEAR(quick.mean, direct.mean, 1e-12 * std::abs(direct.mean) + 1e-12 * direct.sd);
      EXPECT_NEAR(quick.sd, direct.sd, 1e-12 * direct.sd + 1e-15 * std::abs(direct.mean));
      const double length = channel.time(end - 1) - channel.time(first);
      EXPECT_NEAR(quick.slope, direct.slope, (1e-12 * direct.sd + 1e-15 * std::abs(direct.mean)) / length * 10.0);
    }
  }
}

TEST(Pyramid, EverySampleLiesInsideOfItsBar) {
  for (const std::size_t count : {1ul, 63ul, 64ul, 1025ul, 20000ul, 300001ul})
    expect_views_hold(Opened(awkward(count, count), "a.h5"), 17);
}

TEST(Pyramid, EveryStampedSampleLiesInsideOfItsBar) {
  expect_views_hold(Opened(stamped(40000, 5), "a.h5"), 18);
  expect_views_hold(Opened(stamped(3000, 6), "a.csv"), 19);
}

TEST(Pyramid, EveryCountOfDeflatedChunksLiesInsideOfItsBar) {
  for (const std::size_t count : {1ul, 1023ul, 1024ul, 1025ul, 70001ul}) {
    const Opened opened([&](const std::string& path) { write_counts(path, count, 1000); });
    std::mt19937_64 random(count);
    for (std::size_t c = 0; c < 2; ++c) {
      const Channel& channel = opened.recording.channels[c];
      for (int trial = 0; trial < 60; ++trial) {  // spans that begin and end about the borders of chunks
        const double from = 5.0 * static_cast<double>(random() % (count / 1000 + 1)) +
                            0.005 * static_cast<double>(random() % 3) - 0.005;
        const double to = from + 5.0 * static_cast<double>(random() % 70 + 1);
        expect_inside(*opened.pyramid, channel, c, from, to, 1 + random() % 900, channel.unit);
      }
    }
  }
}

// A logger that stood still for an hour, and a clock that jumps back.
TEST(Pyramid, EverySampleAboutAGapLiesInsideOfItsBar) {
  Recording recording = stamped(5000, 8);
  auto stamps = std::make_shared<std::vector<double>>(*recording.channels[0].timeline.stamps);
  for (std::size_t i = 2500; i < stamps->size(); ++i) (*stamps)[i] += 3600.0;
  for (Channel& channel : recording.channels) channel.timeline = {0.0, 0.0, stamps};
  const Opened opened(recording, "a.h5");
  const Channel& channel = opened.recording.channels[0];
  const double before = (*stamps)[2499], after = (*stamps)[2500];
  for (const auto& [from, to] : {std::pair(before, after), {before - 1.0, after + 1.0}, {before + 1.0, after - 1.0}})
    for (const std::size_t pixels : {1ul, 7ul, 300ul})
      expect_inside(*opened.pyramid, channel, 0, from, to, pixels, channel.unit);
}

TEST(Pyramid, AnInfiniteSampleIsRefusedNotDrawn) {
  const ScratchFolder folder;
  std::ofstream(folder.file("a.csv")) << "time[s],gyro.x[deg/s]\n0,1\n0.1,inf\n0.2,3\n0.3,4\n";
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"inf"}, .line = 3, .column = 2},
                      [&] { build_pyramid(folder.file("a.csv"), {}, folder.file("a.pyr"), {}); }));
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.pyr")));
}

TEST(Pyramid, TextHoldsItsOwnSamples) { expect_views_hold(Opened(awkward(5000, 7), "a.csv"), 20); }

TEST(Pyramid, StatisticsOfAnySpanAreThoseOfItsSamples) {
  expect_statistics_agree(Opened(awkward(300001, 1), "a.h5"), 21);
  expect_statistics_agree(Opened(stamped(40000, 2), "a.h5"), 22);
}

TEST(Pyramid, OfNoSamplePresentThereIsNoMean) {
  const Opened opened(awkward(5000, 3), "a.h5");
  const SpanStatistics all = opened.pyramid->statistics(3, 0, 5000);
  EXPECT_EQ(all.missing, 5000u);
  EXPECT_TRUE(std::isnan(all.mean) && std::isnan(all.minimum) && std::isnan(all.slope));
}

TEST(Pyramid, CarriesMarksAndInstrument) {
  const Opened opened(awkward(2000, 4), "a.h5");
  EXPECT_EQ(opened.pyramid->header().instrument, "unit 7");
  ASSERT_EQ(opened.pyramid->header().marks.size(), 2u);
  EXPECT_EQ(opened.pyramid->header().marks[1].label, "spin");
  EXPECT_EQ(opened.pyramid->channels()[0].samples, 2000u);
}

TEST(Pyramid, RefusesADamagedFile) {
  const Opened opened(awkward(2000, 4), "a.csv");
  const std::string path = opened.folder.file("a.pyr");
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  std::mt19937_64 random(9);
  const auto written = [&](const std::string& content) {
    const std::string copy = opened.folder.file("b.pyr");
    std::ofstream(copy, std::ios::binary) << content;
    return copy;
  };
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "damaged"},
                      [&] { Pyramid(written(bytes.substr(0, bytes.size() / 2)), {}); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "damaged"}, [&] { Pyramid(written("x"), {}); }));
  const std::size_t text = bytes.size() - 3000;  // the description: a changed byte may be refused, and must not crash
  for (int trial = 0; trial < 300; ++trial) {
    std::string changed = bytes;
    changed[text + random() % 3000] = static_cast<char>(random());
    try {
      const Pyramid pyramid(written(changed), {});
      for (std::size_t c = 0; c < pyramid.channels().size(); ++c) EXPECT_LE(pyramid.channels()[c].samples, 1u << 30);
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace tumble
