// The C code, compiled by the compilers that are there and run, gives what the calibration gives.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/testing/file_numbers.hpp"
#include "tumble/exchange/testing/random_calibration.hpp"
#include "tumble/units/testing/asserts.hpp"

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

  /// Compilers that are installed with the library of the sanitiser, which Debian has in a package of its own for clang.
  std::vector<std::string> compilers() const {
    std::vector<std::string> found;
    write("empty.c", "int main(void) { return 0; }\n");
    for (const char* name : {"gcc", "clang", "clang-16", "clang-14"})
      if (run(fmt::format("{} -fsanitize=undefined -o {} {} > /dev/null 2>&1", name, path("empty"), path("empty.c"))) ==
          0)
        found.emplace_back(name);
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

const Parts linear{}, tabled{.table = true}, thermal{.thermal_bias = true, .thermal_scale = true},
    everything{.curve = true, .table = true, .thermal_bias = true, .thermal_scale = true};

constexpr const char* sanitized = "-O1 -fsanitize=undefined -fno-sanitize-recover=all";

/// What is compiled how.
const std::pair<const char*, Parts> cases[] = {
    {"-O0", linear}, {"-O2", tabled}, {"-O2", thermal}, {"-O2", everything}, {sanitized, everything}};

TEST_F(CCode, GivesWhatTheCalibrationGives) {
  const auto all = compilers();
  ASSERT_FALSE(all.empty()) << "no C compiler";
  std::uint64_t seed = 0;
  for (const auto& compiler : all)
    for (const auto& [flags, parts] : cases)
      expect_same(random_calibration(seed++, parts), "double", compiler, flags, double_rounding);
}

TEST_F(CCode, FloatIsAsGoodAsFloatsAre) {
  const auto all = compilers();
  ASSERT_FALSE(all.empty()) << "no C compiler";
  for (const auto& compiler : all)
    for (const char* flags : {"-O0", "-O2"})
      expect_same(random_calibration(77, everything), "float", compiler, flags, float_rounding);
}

/// Temperatures and outputs that no sensor gives, up to the greatest number of the type.
TEST_F(CCode, AnyFiniteInputGivesAFiniteOutput) {
  const auto all = compilers();
  ASSERT_FALSE(all.empty()) << "no C compiler";
  for (const auto& [type, most] : {std::pair{"double", 1.7e308}, {"float", 3.4e38}}) {
    expect_same(random_calibration(8, everything), type, all[0], "-O2",
                std::string(type) == "double" ? double_rounding : float_rounding);
    std::vector<ImuSample> raws;
    for (const double size : {most, -most, 1e20, -1e9, 0.0})
      for (const double celsius : {most, -most, 1e9, -273.15})
        raws.push_back({{size, -size, size}, {-size, size, 0.0}, celsius + 273.15, {}});
    const auto found = consumed(raws);
    ASSERT_EQ(found.size(), raws.size()) << type << ": inf and nan are no numbers to a stream";
    for (const ImuSample& sample : found) EXPECT_TRUE(is_finite(sample.force) && is_finite(sample.rate)) << type;
  }
}

/// Integers in, integers out: the formats stand in the file as macros.
constexpr const char* integer_reader =
    "#include <stdio.h>\n#include \"calibration.c\"\n"
    R"(
int main(void)
{
  int32_t raw[6];
  int32_t out[6];
  int32_t t;
  printf("%d %d %d %d\n", ACCELEROMETER_RAW_BITS, ACCELEROMETER_COMPENSATED_BITS, GYRO_RAW_BITS, GYRO_COMPENSATED_BITS);
  while (scanf("%d %d %d %d %d %d %d", &raw[0], &raw[1], &raw[2], &raw[3], &raw[4], &raw[5], &t) == 7)
  {
    tumble_compensate(raw, t, out);
    printf("%d %d %d %d %d %d\n", out[0], out[1], out[2], out[3], out[4], out[5]);
  }
  return 0;
}
)";

struct FixedCase {
  double force_error = 0.0, rate_error = 0.0;  ///< as the file states them
  double force_found = 0.0, rate_found = 0.0;  ///< as the code shows them
};

FixedCase fixed_case(const std::string& text, const std::string& formats, const ImuCalibration& calibration,
                     std::istream& out, const std::vector<std::array<int, 7>>& raws) {
  int a = 0, ac = 0, g = 0, gc = 0;
  EXPECT_EQ(std::sscanf(formats.c_str(), "%d %d %d %d", &a, &ac, &g, &gc), 4);
  FixedCase found{testing::number_after(text, "rounding error below"),
                  testing::number_after(text.substr(text.find("gyros raw")), "rounding error below")};
  for (const auto& raw : raws) {
    ImuSample sample{{}, {}, std::ldexp(raw[6], -16) + 273.15, {}};
    Vector3 force, rate;
    for (std::size_t i = 0; i < 3; ++i) {
      sample.force[i] = std::ldexp(raw[i], -a), sample.rate[i] = std::ldexp(raw[i + 3], -g);
      double value = 0.0;
      EXPECT_TRUE(out >> value);
      force[i] = std::ldexp(value, -ac);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      double value = 0.0;
      EXPECT_TRUE(out >> value);
      rate[i] = std::ldexp(value, -gc);
    }
    const ImuSample wanted = compensated(calibration, sample);
    for (std::size_t i = 0; i < 3; ++i) {
      found.force_found = std::max(found.force_found, std::abs(force[i] - wanted.force[i]));
      found.rate_found = std::max(found.rate_found, std::abs(rate[i] - wanted.rate[i]));
    }
  }
  return found;
}

/// 2000 outputs of a unit as integers: six outputs and a temperature.
std::vector<std::array<int, 7>> integers_of(const ImuCalibration& calibration, const std::string& text) {
  const double a = std::exp2(testing::number_after(text, "ACCELEROMETER_RAW_BITS (")),
               g = std::exp2(testing::number_after(text, "GYRO_RAW_BITS ("));
  std::vector<std::array<int, 7>> raws;
  for (std::uint64_t k = 0; k < 2000; ++k) {
    const ImuSample raw = outputs_of(calibration, random_truth(k));
    raws.push_back({});
    for (std::size_t i = 0; i < 3; ++i) {
      raws.back()[i] = static_cast<int>(std::lround(a * raw.force[i]));
      raws.back()[i + 3] = static_cast<int>(std::lround(g * raw.rate[i]));
    }
    raws.back()[6] = static_cast<int>(std::lround(65536.0 * (raw.temperature - 273.15)));
  }
  return raws;
}

TEST_F(CCode, FixedPointStaysWithinTheErrorThatItStates) {
  const auto all = compilers();
  ASSERT_FALSE(all.empty()) << "no C compiler";
  std::uint64_t seed = 100;
  for (const auto& compiler : all)
    for (const auto& [flags, parts] : cases) {
      const ImuCalibration calibration = random_calibration(seed++, parts);
      ExportRequest asked;
      asked.settings.push_back({"type", "fixed", "--set", true, true});
      const std::string text = export_calibration(find_export("c"), calibration, asked);
      write("calibration.c", text);
      write("main.c", integer_reader);
      const auto compile = [&](const char* more, const char* program, const char* source) {
        return run(fmt::format("{} {} {} {} -o {} {}", compiler, warnings, flags, more, path(program), path(source)));
      };
      ASSERT_EQ(compile("", "program", "main.c"), 0) << compiler << " " << flags;
      ASSERT_EQ(compile("-DTUMBLE_CAL_TEST", "self_test", "calibration.c"), 0) << compiler << " " << flags;
      EXPECT_EQ(run(fmt::format("{} > {}", path("self_test"), path("self_test.txt"))), 0);
      const auto raws = integers_of(calibration, text);
      std::string lines;
      for (const auto& raw : raws) lines += fmt::format("{}\n", fmt::join(raw, " "));
      write("in.txt", lines);
      ASSERT_EQ(run(fmt::format("{} < {} > {}", path("program"), path("in.txt"), path("out.txt"))), 0);
      std::ifstream out(path("out.txt"));
      std::string formats;
      std::getline(out, formats);
      const FixedCase found = fixed_case(text, formats, calibration, out, raws);
      EXPECT_LE(found.force_found, found.force_error) << compiler << " " << flags;
      EXPECT_LE(found.rate_found, found.rate_error) << compiler << " " << flags;
      EXPECT_GT(found.force_found, 0.05 * found.force_error) << "the stated error is far too large";
      EXPECT_LT(found.force_error, 1e-6);  // 2^-24 of 20 m/s^2 is 1.2e-6: better than float
    }
}

/// One axis of a range of a hundredth of the others, with powers as steep as the code takes; and a table of points far
/// outside of its range.
ImuCalibration narrow_axis() {
  ImuCalibration c = random_calibration(11, linear);
  c.gyros.range = {0.04, 4.0, 4.0};
  c.gyros.curve[0].power = {0.5, 0.0, 0.0, 2000.0};
  c.gyros.curve[2].table = {{-4000.0, -1.0, 4000.0}, {300.0, -0.1, -400.0}};
  return c;
}

/// Outputs far beyond the range give limited numbers, without an overflow.
TEST_F(CCode, FixedPointTakesAnyInteger) {
  const auto all = compilers();
  ASSERT_FALSE(all.empty()) << "no C compiler";
  ExportRequest asked;
  asked.settings.push_back({"type", "fixed", "--set", true, true});
  std::string lines;
  for (int k = 0; k < 3 * 128; ++k) {
    const auto size = std::array{2147483647LL, 1LL << 29, 1LL << 20}[static_cast<std::size_t>(k / 128)];
    for (int i = 0; i < 7; ++i) lines += fmt::format("{} ", (k >> i) & 1 ? size : -size - 1);
    lines += "\n";
  }
  for (const ImuCalibration& calibration : {random_calibration(7, everything), narrow_axis()}) {
    write("calibration.c", export_calibration(find_export("c"), calibration, asked));
    write("main.c", integer_reader);
    ASSERT_EQ(run(fmt::format("{} {} -fsanitize=undefined -fno-sanitize-recover=all -o {} {}", all[0], warnings,
                              path("program"), path("main.c"))),
              0);
    write("in.txt", lines);
    EXPECT_EQ(run(fmt::format("{} < {} > {}", path("program"), path("in.txt"), path("out.txt"))), 0);
    ASSERT_EQ(run(fmt::format("{} {} -DTUMBLE_CAL_TEST -o {} {} && {} > {}", all[0], warnings, path("self_test"),
                              path("calibration.c"), path("self_test"), path("self_test.txt"))),
              0);
  }
}

/// So do floats: the passes that solve for a steep power end in numbers, although they do not converge there.
TEST_F(CCode, FloatingPointFarBeyondTheRangeIsFinite) {
  const auto all = compilers();
  ASSERT_FALSE(all.empty()) << "no C compiler";
  for (const std::string type : {"float", "double"}) {
    ExportRequest asked;
    asked.settings.push_back({"type", type, "--set", true, true});
    write("calibration.c", export_calibration(find_export("c"), narrow_axis(), asked));
    std::string text = reader;
    for (auto at = text.find("REAL"); at != std::string::npos; at = text.find("REAL")) text.replace(at, 4, type);
    write("main.c", text);
    ASSERT_EQ(
        run(fmt::format("{} {} -o {} {} {}", all[0], warnings, path("program"), path("calibration.c"), path("main.c"))),
        0);
    std::vector<ImuSample> raws;
    for (const double size : {0.04, 0.1, 1.0, 100.0, 1e6})
      raws.push_back({size * Vector3{1.0, -1.0, 1.0}, size * Vector3{-1.0, 1.0, 1.0}, 293.15, {}});
    const auto found = consumed(raws);  // reading ends at a word such as inf
    ASSERT_EQ(found.size(), raws.size());
    for (std::size_t k = 0; k < raws.size(); ++k)
      EXPECT_LT(norm(found[k].rate), 2.0 * norm(raws[k].rate) + 1.0) << type << ", sample " << k;
  }
}

TEST_F(CCode, SelfTestFindsAWrongNumber) {
  const auto all = compilers();
  ASSERT_FALSE(all.empty()) << "no C compiler";
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
  const auto named = [](const char* name) {
    ExportRequest asked;
    asked.settings.push_back({"function", name, "--set", true, true});
    return export_calibration(find_export("c"), random_calibration(5, linear), asked);
  };
  for (const char* name : {"2 bad", "int", "main", "nullptr", "_Bool", "multiply", "gyro_bias", "printf", "uint32_t"})
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {name}, .pattern = "function = "}, [&] {
      named(name);
    })) << name;
  for (const char* name : {"NAME", "REAL", "KIND_of_mine", "tumble", "gyro"})
    EXPECT_NE(named(name).find(fmt::format("void {}(const float raw[6]", name)), std::string::npos) << name;
}

}  // namespace
}  // namespace tumble
