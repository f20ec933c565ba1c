// Files for MATLAB are run by Octave, which is no part of the product: what it reads is what the calibration says.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/testing/random_calibration.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"

namespace tumble {
namespace {

using testing::random_calibration;
using testing::random_truth;

constexpr std::uint64_t octave_calibrations = 20;
constexpr double tolerance = 1e-12;

std::string row_of(Vector3 v) { return fmt::format("[{:.17g} {:.17g} {:.17g}]", v.x, v.y, v.z); }

/// Stubs of the toolbox, and a function that prints a vector under a name.
constexpr const char* octave_begin = R"(1;
function p = accelparams(varargin) p = struct(varargin{:}); end
function p = gyroparams(varargin) p = struct(varargin{:}); end
function p = imuSensor(kind, varargin) p = struct(varargin{:}); end
function say(name, v) printf('%s %.17g %.17g %.17g\n', name, v(1), v(2), v(3)); end
)";

/// The consumer's formulas; w and f are columns.
constexpr const char* psins_says = R"(source('{0}/psins.m');
say('{1} psins_rate', clbt.Kg*(clbt.sf(1:3).*w) - clbt.gSens*(clbt.sf(4:6).*f) - clbt.eb);
say('{1} psins_force', clbt.Ka*(clbt.sf(4:6).*f) - clbt.db);
say('{1} psins_N_gyro', imuerr.web); say('{1} psins_N_force', imuerr.wdb);
say('{1} psins_K_gyro', imuerr.sqg); say('{1} psins_K_force', imuerr.sqa);
clear clbt imuerr
)";
constexpr const char* matlab_says = R"(source('{0}/matlab.m');
say('{1} matlab_rate', calibration.rate(f', w')); say('{1} matlab_force', calibration.force(f'));
say('{1} matlab_N_gyro', imu.Gyroscope.NoiseDensity); say('{1} matlab_K_force', imu.Accelerometer.RandomWalk);
say('{1} matlab_sampling', [imu.SampleRate 0 0]);
clear calibration imu
)";
/// imu_si_errors.m: /60, degrees to radians, milli-g.
constexpr const char* navego_says = R"(source('{0}/navego.m');
say('{1} navego_N_gyro', imu.arw/60*pi/180); say('{1} navego_N_force', imu.vrw/60);
say('{1} navego_K_gyro', imu.arrw/60*pi/180); say('{1} navego_K_force', imu.vrrw/60);
clear imu
)";

class OctaveReads : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("octave-cli --version > /dev/null 2>&1") != 0)
      GTEST_SKIP() << "octave-cli is not installed: script/bootstrap script/packages-octave.txt (248 MB)";
  }

  /// "3 psins_rate" and the numbers that Octave prints for it.
  std::map<std::string, Vector3> run(const std::string& script) {
    std::ofstream(folder_.file("run.m")) << script;
    const std::string output = folder_.file("output");
    const std::string command = "octave-cli --norc --quiet " + folder_.file("run.m") + " > " + output + " 2>&1";
    const int status = std::system(command.c_str());
    std::ifstream said(output);
    std::map<std::string, Vector3> values;
    std::string number, name;
    for (Vector3 v; said >> number >> name >> v.x >> v.y >> v.z;) values[number + " " + name] = v;
    std::ifstream again(output);
    EXPECT_EQ(status, 0) << std::string(std::istreambuf_iterator<char>(again), {});
    return values;
  }

  ScratchFolder folder_;
};

void expect_near(const std::map<std::string, Vector3>& read, const std::string& name, Vector3 wanted) {
  const auto found = read.find(name);
  ASSERT_NE(found, read.end()) << name;
  EXPECT_LE(norm(found->second - wanted), tolerance * std::max(1.0, norm(wanted))) << name;
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(found->second[i], wanted[i], 1e-9 * std::abs(wanted[i])) << name;  // of small numbers too
}

Vector3 each_axis(const TriadCalibration& triad, double AxisNoise::*term) {
  return {triad.noise[0].*term, triad.noise[1].*term, triad.noise[2].*term};
}

TEST_F(OctaveReads, WhatTheCalibrationSays) {
  ExportRequest at_100_hz;
  at_100_hz.settings.push_back({"rate", "100", "--set", true, true});
  std::string script = octave_begin;
  std::vector<ImuCalibration> calibrations;
  std::vector<ImuSample> raw;
  for (std::uint64_t seed = 0; seed < octave_calibrations; ++seed) {
    calibrations.push_back(random_calibration(seed, {}));
    const ImuCalibration& c = calibrations.back();
    raw.push_back(outputs_of(c, random_truth(seed)));
    const std::string at = folder_.file(std::to_string(seed));
    std::filesystem::create_directory(at);
    std::ofstream(at + "/psins.m") << export_calibration(find_export("psins"), c, {});
    std::ofstream(at + "/matlab.m") << export_calibration(find_export("matlab"), c, at_100_hz);
    ImuCalibration noise = c;  // NaveGo takes no calibration
    for (TriadCalibration* t : {&noise.accelerometers, &noise.gyros})
      t->calibrated = false, t->response = identity3(), t->bias = {}, t->by_force = {};
    std::ofstream(at + "/navego.m") << export_calibration(find_export("navego"), noise, at_100_hz);
    script += fmt::format("w = {}'; f = {}';\n", row_of(raw.back().rate), row_of(raw.back().force));
    for (const char* says : {psins_says, matlab_says, navego_says}) script += fmt::format(fmt::runtime(says), at, seed);
  }
  const auto read = run(script);
  for (std::uint64_t seed = 0; seed < octave_calibrations; ++seed) {
    const ImuCalibration& c = calibrations[seed];
    const ImuSample wanted = compensated(c, raw[seed]);
    const std::string number = std::to_string(seed) + " ";
    for (const char* name : {"psins", "matlab"}) {
      expect_near(read, number + name + "_rate", wanted.rate);
      expect_near(read, number + name + "_force", wanted.force);
    }
    for (const char* name : {"psins", "navego", "matlab"})
      expect_near(read, number + name + "_N_gyro", each_axis(c.gyros, &AxisNoise::white));
    for (const char* name : {"psins", "navego", "matlab"})
      expect_near(read, number + name + "_K_force", each_axis(c.accelerometers, &AxisNoise::walk));
    for (const char* name : {"psins", "navego"}) {
      expect_near(read, number + name + "_N_force", each_axis(c.accelerometers, &AxisNoise::white));
      expect_near(read, number + name + "_K_gyro", each_axis(c.gyros, &AxisNoise::walk));
    }
    expect_near(read, number + "matlab_sampling", {100.0, 0.0, 0.0});
  }
}

}  // namespace
}  // namespace tumble
