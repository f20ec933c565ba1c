// Layouts of HDF5 that are read without the library: every sample is the one that was written.

#include "tumble/formats/hdf5/raw.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "tumble/formats/format.hpp"
#include "tumble/formats/random_access.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::hdf5 {
namespace {

struct Layout {
  std::string name;
  hsize_t chunk = 0;
  bool shuffle = false, deflate = false, checksum = false;
  hid_t type = H5T_IEEE_F64LE;
  hsize_t user_block = 0;
  bool is_raw = true;  ///< read without the library
};

/// The types of HDF5 begin the library, which has to be told before what it is not to do at the exit.
const std::vector<Layout>& layouts() {
  const Session session;
  static const std::vector<Layout> all{{"contiguous"},
                                       {"chunks", 1000},
                                       {"one long chunk", 200000},
                                       {"deflated", 1000, false, true},
                                       {"shuffled and deflated", 1024, true, true},
                                       {"chunks of odd length", 37, true, true},
                                       {"with a checksum", 1000, false, true, true, H5T_IEEE_F64LE, 0, false},
                                       {"counts", 1000, false, true, false, H5T_STD_I16LE, 0, false},
                                       {"single precision", 0, false, false, false, H5T_IEEE_F32LE, 0, false},
                                       {"behind a user block", 0, false, false, false, H5T_IEEE_F64LE, 512, false}};
  return all;
}

std::vector<double> counts(std::size_t count) {
  std::mt19937_64 random(count);
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<double>(random() % 4001) - 2000.0);
  return values;
}

void write(const std::string& path, const Layout& layout, const std::vector<double>& values) {
  const Session session;
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_userblock(creation, layout.user_block);
  const Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, H5P_DEFAULT), H5Fclose);
  const Handle group(H5Gcreate2(file, "/channels", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  const hsize_t size = values.size(), most = layout.chunk ? H5S_UNLIMITED : size;
  const Handle space(H5Screate_simple(1, &size, &most), H5Sclose), plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  if (layout.chunk) H5Pset_chunk(plist, 1, &layout.chunk);
  if (layout.shuffle) H5Pset_shuffle(plist);
  if (layout.deflate) H5Pset_deflate(plist, 3);
  if (layout.checksum) H5Pset_fletcher32(plist);
  const Handle dataset(H5Dcreate2(file, "/channels/gyro", layout.type, space, H5P_DEFAULT, plist, H5P_DEFAULT),
                       H5Dclose);
  H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle rate(H5Acreate2(dataset, "rate", H5T_IEEE_F64LE, scalar, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const double hertz = 100.0;
  H5Awrite(rate, H5T_NATIVE_DOUBLE, &hertz);
  const Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(text, 5);
  const Handle unit(H5Acreate2(dataset, "unit", text, scalar, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  H5Awrite(unit, text, "rad/s");
}

bool is_raw(const std::string& path, hsize_t count) {
  const Session session;
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  const Handle dataset(H5Dopen2(file, "/channels/gyro", H5P_DEFAULT), H5Dclose);
  const Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  return raw_samples(file, dataset, plist, 1, count, std::filesystem::file_size(path)).has_value();
}

TEST(RawSamples, AreThoseThatWereWrittenInEveryLayout) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.h5");
  for (const Layout& layout : layouts())
    for (const std::size_t count : {1ul, 999ul, 1000ul, 1001ul, 100003ul}) {
      const auto values = counts(count);
      write(path, layout, values);
      EXPECT_EQ(is_raw(path, count), layout.is_raw) << layout.name;
      EXPECT_EQ(read_recording(path, {}, {}).channels.at(0).values, values) << layout.name << ' ' << count;
      const SampleReader reader = sample_reader(path, {});
      for (const std::size_t first : {0ul, 998ul, 999ul, 1000ul, 1001ul, count - 1}) {
        if (first >= count) continue;
        std::vector<double> some{7.0};
        const std::size_t length = std::min<std::size_t>(count - first, 1003);
        reader(0, first, length, some);
        std::vector<double> wanted{7.0};
        wanted.insert(wanted.end(), values.begin() + static_cast<std::ptrdiff_t>(first),
                      values.begin() + static_cast<std::ptrdiff_t>(first + length));
        EXPECT_EQ(some, wanted) << layout.name << ' ' << count << ' ' << first;
      }
    }
}

TEST(RawSamples, MissingOnesAreReadAndInfiniteOnesAreRefused) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.h5");
  for (const Layout& layout : {layouts()[0], layouts()[1], layouts()[3], layouts()[4]})
    for (const std::size_t place : {0ul, 5ul, 1000ul, 4998ul}) {
      auto values = counts(5000);
      values[place] = std::nan("");
      write(path, layout, values);
      EXPECT_TRUE(std::isnan(read_recording(path, {}, {}).channels.at(0).values[place]));
      for (const double infinite : {HUGE_VAL, -HUGE_VAL}) {
        values[place] = infinite;
        write(path, layout, values);
        EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "an infinite sample"},
                            [&] { read_recording(path, {}, {}); }))
            << layout.name << ' ' << place;
      }
    }
}

// The reason is that of the library.
TEST(RawSamples, DamagedAndCutOffChunksAreRefused) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.h5");
  for (const Layout& layout : {layouts()[0], layouts()[1], layouts()[3], layouts()[4]}) {
    write(path, layout, counts(100000));
    std::ifstream file(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    std::ofstream(path, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {path}}, [&] { read_recording(path, {}, {}); }))
        << layout.name;
    if (!layout.deflate) continue;
    std::string damaged = bytes;
    for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 4000; ++i) damaged[i] = 'x';
    std::ofstream(path, std::ios::binary) << damaged;
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"gyro"}}, [&] { read_recording(path, {}, {}); }))
        << layout.name;
  }
}

}  // namespace
}  // namespace tumble::hdf5
