// The C code, compiled by the compilers that are there and run, gives what the calibration gives.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/testing/random_calibration.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using testing::Parts;
using testing::random_calibration;
using testing::random_truth;

namespace fs = std::filesystem;

constexpr const char* warnings = "-std=c99 -pedantic -Wall -Wextra -Wconversion -Werror";

/// A program around the function: seven numbers a line in, six out.
constexpr const char* reader = R"(#include <stdio.h>
void tumble_compensate(const REAL raw[6], REAL temperature, REAL compensated[6]);
int main(void)
{
  double in[7];
  REAL raw[6];
  REAL out[6];
  int i;
  while (scanf("%lf %lf %lf %lf %lf %lf %lf", &in[0], &in[1], &in[2], &in[3], &in[4], &in[5], &in[6]) == 7)
  {
    for (i = 0; i < 6; i++) { raw[i] = (REAL)in[i]; }
    tumble_compensate(raw, (REAL)in[6], out);
    printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", (double)out[0], (double)out[1], (double)out[2], (double)out[3],
           (double)out[4], (double)out[5]);
  }
  return 0;
}
)";

/// A folder of its own that is removed at the end.
class CCode : public ::testing::Test {
 protected:
  CCode() : folder_(fs::path(::testing::TempDir()) / fmt::format("tumble_c_{}", ::getpid())) {
    fs::create_directories(folder_);
  }
  ~CCode() override { fs::remove_all(folder_); }

  std::string path(const char* name) const { return (folder_ / name).string(); }
  void write(const char* name, const std::string& text) const { std::ofstream(path(name)) << text; }
  static int run(const std::string& command) { return std::system(command.c_str()); }

  static std::vector<std::string> compilers() {
    std::vector<std::string> found;
    for (const char* name : {"gcc", "clang", "clang-16", "clang-14"})
      if (run(fmt::format("command -v {} > /dev/null 2>&1", name)) == 0) found.emplace_back(name);
    return found;
  }

  /// Compensated samples, as the compiled code gives them.
  std::vector<ImuSample> consumed(const std::vector<ImuSample>& raws) const {
    std::string lines;
    for (const ImuSample& raw : raws)
      lines += fmt::format("{} {} {} {} {} {} {}\n", raw.force.x, raw.force.y, raw.force.z, raw.rate.x, raw.rate.y,
                           raw.rate.z, raw.temperature - 273.15);
    write("in.txt", lines);
    EXPECT_EQ(run(fmt::format("{} < {} > {}", path("program"), path("in.txt"), path("out.txt"))), 0);
    std::ifstream out(path("out.txt"));
    std::vector<ImuSample> samples;
    for (ImuSample s; out >> s.force.x >> s.force.y >> s.force.z >> s.rate.x >> s.rate.y >> s.rate.z;)
      samples.push_back(s);
    return samples;
  }

  /// Compiles with these flags; compares the code with the calibration and runs its self-test.
  void expect_same(const ImuCalibration& calibration, const std::string& type, const std::string& compiler,
                   const std::string& flags, double tolerance) const {
    ExportRequest asked;
    asked.settings.push_back({"type", type, "--set", true, true});
    write("calibration.c", export_calibration(find_export("c"), calibration, asked));
    std::string text = reader;
    for (auto at = text.find("REAL"); at != std::string::npos; at = text.find("REAL")) text.replace(at, 4, type);
    write("main.c", text);
    ASSERT_EQ(run(fmt::format("{} {} {} -o {} {} {}", compiler, warnings, flags, path("program"), path("calibration.c"),
                              path("main.c"))),
              0)
        << compiler << " " << flags;
    std::vector<ImuSample> raws;
    for (std::uint64_t k = 0; k < 1000; ++k) raws.push_back(outputs_of(calibration, random_truth(k)));
    const auto found = consumed(raws);
    ASSERT_EQ(found.size(), raws.size());
    for (std::size_t k = 0; k < raws.size(); ++k)
      ASSERT_LT(testing::difference(found[k], compensated(calibration, raws[k])), tolerance)
          << compiler << " " << flags << ", sample " << k;
    ASSERT_EQ(run(fmt::format("{} {} {} -DTUMBLE_CAL_TEST -o {} {} && {} > {}", compiler, warnings, flags,
                              path("self_test"), path("calibration.c"), path("self_test"), path("self_test.txt"))),
              0)
        << compiler << " " << flags;
  }

 private:
  fs::path folder_;
};

/// 100 rounding errors of 20 m/s^2.
constexpr double double_rounding = 100.0 * 20.0 * 0x1p-53, float_rounding = 100.0 * 20.0 * 0x1p-24;

const Parts linear{}, thermal{.thermal_bias = true, .thermal_scale = true},
    everything{.curve = true, .thermal_bias = true, .thermal_scale = true};

TEST_F(CCode, GivesWhatTheCalibrationGives) {
  const auto all = compilers();
  if (all.empty()) GTEST_SKIP() << "no C compiler";
  std::uint64_t seed = 0;
  for (const auto& compiler : all)
    for (const char* flags : {"-O0", "-O2", "-O1 -fsanitize=undefined -fno-sanitize-recover=all"})
      for (const Parts& parts : {linear, thermal, everything}) {
        const ImuCalibration calibration = random_calibration(seed++, parts);
        expect_same(calibration, "double", compiler, flags, double_rounding);
      }
}

TEST_F(CCode, FloatIsAsGoodAsFloatsAre) {
  const auto all = compilers();
  if (all.empty()) GTEST_SKIP() << "no C compiler";
  for (const auto& compiler : all)
    for (const char* flags : {"-O0", "-O2"})
      expect_same(random_calibration(77, everything), "float", compiler, flags, float_rounding);
}

TEST_F(CCode, SelfTestFindsAWrongNumber) {
  const auto all = compilers();
  if (all.empty()) GTEST_SKIP() << "no C compiler";
  std::string text = export_calibration(find_export("c"), random_calibration(5, everything), {});
  const auto bias = text.find("gyro_bias[3] = {");
  ASSERT_NE(bias, std::string::npos);
  text.insert(text.find('{', bias) + 1, "1.0F + ");
  write("wrong.c", text);
  ASSERT_EQ(run(fmt::format("{} {} -DTUMBLE_CAL_TEST -o {} {}", all[0], warnings, path("wrong"), path("wrong.c"))), 0);
  EXPECT_NE(run(fmt::format("{} > {}", path("wrong"), path("wrong.txt"))), 0);
}

TEST(ExportC, UsesNeitherLibmNorMalloc) {
  const std::string text = export_calibration(find_export("c"), random_calibration(5, everything), {});
  EXPECT_EQ(text.find("math.h"), std::string::npos);
  EXPECT_EQ(text.find("alloc"), std::string::npos);
}

TEST(ExportC, NameThatCDoesNotTakeIsRefused) {
  ExportRequest asked;
  asked.settings.push_back({"function", "2 bad", "--set", true, true});
  EXPECT_THROW(export_calibration(find_export("c"), random_calibration(5, linear), asked), Error);
}

}  // namespace
}  // namespace tumble
