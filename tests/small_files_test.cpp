// A file of a few kilobytes may not take all memory, or for ever: tests/reference/attack. The time limit of the test is the
// limit of time.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <string>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// [kB] most memory that the process has had so far.
long most_memory() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return used.ru_maxrss;
}

struct SmallFile {
  const char* name;
  const char* variable;  ///< that has the unit 1; empty: none
  std::size_t channels;  ///< that are read; 0: it is refused
};

class SmallFiles : public ::testing::TestWithParam<SmallFile> {};

TEST_P(SmallFiles, TakeLittleMemoryAndTime) {
  const SmallFile& file = GetParam();
  const std::string path = std::string(TUMBLE_SOURCE_DIR "/tests/reference/attack/") + file.name;
  ReadOptions options;
  if (*file.variable != '\0') options.units[file.variable] = Unit::parse("1");
  const long before = most_memory();
  if (file.channels > 0)
    EXPECT_EQ(read_recording(path, options, {}).channels.size(), file.channels);
  else
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{}, [&] { read_recording(path, options, {}); }));
  constexpr long a_gigabyte = 1'000'000;  // kB; those that had no limit took 5 to 13
  EXPECT_LT(most_memory() - before, a_gigabyte);
}

INSTANTIATE_TEST_SUITE_P(
    Attack, SmallFiles,
    ::testing::Values(SmallFile{"bag2_ids_at_2_63.db3.gz", "", 10}, SmallFile{"hdf5_300_hard_links.h5.gz", "", 0},
                      SmallFile{"lvm_same_names_4000.lvm.gz", "", 4000}, SmallFile{"lvm_step_1e308.lvm", "", 0},
                      SmallFile{"mat_same_names_5000.mat.gz", "a", 5000},
                      SmallFile{"mat_skipped_names.mat.gz", "gyro", 1}, SmallFile{"mat_tiny_arrays.mat.gz", "c", 0},
                      SmallFile{"uff_step_1e308.uff", "", 0}, SmallFile{"ulog_empty_formats.ulg", "", 0}),
    [](const auto& file) {
      const std::string name = file.param.name;
      return name.substr(0, name.find('.'));
    });

}  // namespace
}  // namespace tumble
