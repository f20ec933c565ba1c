// Files of HDF5 that other programs, or mishaps, make: our own writer makes none of these.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/hdf5/handle.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::hdf5 {
namespace {

class Links : public testing::Test {
 protected:
  void SetUp() override {
    Recording recording;
    for (const char* name : {"gyro", "other"})
      recording.channels.push_back(
          {name, QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, 1.0, nullptr}, {1.0, 2.0, 3.0}});
    write_recording(recording, path("data.h5"));
  }

  std::string path(const char* name) const { return folder_.file(name); }

  /// A file with a group /channels, to which `add` adds.
  template <class Add>
  std::string made(const char* name, const Add& add) const {
    const Session session;
    const Handle file(H5Fcreate(path(name).c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
    const Handle group(H5Gcreate2(file, "/channels", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    add(file);
    return path(name);
  }

  static Refused refusal(const std::string& file) {
    return refusal_of([&] { read_recording(file, {}, {}); });
  }

  ScratchFolder folder_;
};

// The checksum of a result is that of the file that is named: samples of another file would be under a wrong one.
TEST_F(Links, ToAnotherFileAreRefused) {
  const auto linked = made("linked.h5", [](hid_t file) {
    H5Lcreate_external("data.h5", "/channels/gyro", file, "/channels/gyro", H5P_DEFAULT, H5P_DEFAULT);
  });
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"gyro"}, .pattern = "a link leads to another file"},
                      refusal(linked)));
  const auto around = made("around.h5", [](hid_t file) {
    H5Lcreate_external("data.h5", "/channels", file, "/elsewhere", H5P_DEFAULT, H5P_DEFAULT);
    H5Ldelete(file, "/channels", H5P_DEFAULT);
    H5Lcreate_soft("/elsewhere", file, "/channels", H5P_DEFAULT, H5P_DEFAULT);
  });
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "a link leads to another file"}, refusal(around)));
}

TEST_F(Links, ToADatasetOfTheFileAreChannels) {
  const auto with_link = [&](const char* name, const char* target) {
    return made(name, [&](hid_t at) {
      const Handle data(H5Fopen(path("data.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
      H5Ocopy(data, "/channels/gyro", at, "/channels/gyro", H5P_DEFAULT, H5P_DEFAULT);
      H5Lcreate_soft(target, at, "/channels/linked", H5P_DEFAULT, H5P_DEFAULT);
    });
  };
  const auto recording = read_recording(with_link("soft.h5", "/channels/gyro"), {}, {});
  ASSERT_EQ(recording.channels.size(), 2u);
  EXPECT_EQ(recording.channels[0].values, recording.channels[1].values);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"linked"}}, refusal(with_link("lost.h5", "/none"))));
}

// Whoever opens a recording would see the words of a file of his own.
TEST_F(Links, TextOfAnotherFileIsNotRead) {
  write_file_atomically(path("secret.json"), R"({"operator": "SECRET"})");
  const auto file = made("text.h5", [&](hid_t at) {
    H5Ldelete(at, "/channels", H5P_DEFAULT);
    const Handle data(H5Fopen(path("data.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    H5Ocopy(data, "/channels", at, "/channels", H5P_DEFAULT, H5P_DEFAULT);
    const hsize_t size = 1;
    const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose), plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(text, 22);
    H5Pset_external(plist, path("secret.json").c_str(), 0, 22);
    const Handle dataset(H5Dcreate2(at, "/meta", text, space, H5P_DEFAULT, plist, H5P_DEFAULT), H5Dclose);
    ASSERT_TRUE(dataset.valid());
  });
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "its text is in another file"}, refusal(file)));
}

// Chunks of 2^26 numbers in a file of a few kB: half a gigabyte would be asked for.
TEST_F(Links, ChunksThatTheFileCannotHoldAreRefused) {
  const auto file = made("chunks.h5", [](hid_t at) {
    const hsize_t size = 3, chunk = hsize_t{1} << 26, most = H5S_UNLIMITED;
    const Handle space(H5Screate_simple(1, &size, &most), H5Sclose), plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_chunk(plist, 1, &chunk);
    const Handle dataset(H5Dcreate2(at, "/channels/gyro", H5T_IEEE_F64LE, space, H5P_DEFAULT, plist, H5P_DEFAULT),
                         H5Dclose);
  });
  EXPECT_TRUE(refuses(Error::Kind::bad_file,
                      Asked{.pattern = "its chunks are larger than a file of this size can hold"}, refusal(file)));
}

}  // namespace
}  // namespace tumble::hdf5
