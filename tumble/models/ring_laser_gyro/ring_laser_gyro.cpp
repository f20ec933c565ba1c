#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "tumble/models/lock_in.hpp"
#include "tumble/models/model.hpp"
#include "tumble/models/sagnac.hpp"
#include "tumble/units/error.hpp"

namespace tumble::ring_laser_gyro {
namespace {

using Type = Option::Type;

std::vector<Option> constants() {
  return {
      {"scale_factor", Type::quantity, "pulse/arcsec", "", {}, "K: fringes for each angle; default: 4 A/(lambda L)"},
      {"wavelength", Type::quantity, "nm", "632.8 nm", {}, "lambda, in vacuum"},
      {"shape", Type::word, "1", "triangle", {"triangle", "square"}, "shape of the ring"},
      {"side", Type::quantity, "mm", "100 mm", {}, "side of the ring; area and perimeter replace it"},
      {"area", Type::quantity, "cm^2", "", {}, "A: area inside the ring; needs perimeter"},
      {"perimeter", Type::quantity, "mm", "", {}, "L: perimeter of the ring; needs area"},
      {"lock_in_rate", Type::quantity, "deg/s", "0 deg/s", {}, "W_L: half width of the dead band without dither"},
      {"dither_rate", Type::quantity, "deg/s", "0 deg/s", {}, "W_A: peak rate of the dither; 0: none"},
      {"dither_frequency", Type::quantity, "Hz", "400 Hz", {}, "f_D: frequency of the dither"},
      {"dither_noise", Type::quantity, "1", "0", {}, "sd of the angle of each turn-around, relative to the angle"},
      {"readout",
       Type::word,
       "1",
       "case",
       {"case", "block"},
       "support of the readout: on the block its output contains the dither angle"},
      {"output", Type::word, "1", "count", {"count", "rate"}, "counts in each interval, or the mean rate over it"},
      {"edges", Type::integer, "1", "1", {}, "counts for each fringe: 1, 2 or 4"},
  };
}

void refuse(const Settings& truth) {
  std::vector<std::string> problems;
  const auto positive = [&](const char* name) {
    if (truth.has(name) && !(truth.number(name) > 0.0))
      problems.push_back(fmt::format("ring_laser_gyro: {} must be positive", name));
  };
  const auto not_negative = [&](const char* name) {
    if (truth.number(name) < 0.0) problems.push_back(fmt::format("ring_laser_gyro: {} must not be negative", name));
  };
  for (const char* name : {"scale_factor", "wavelength", "side", "area", "perimeter", "dither_frequency"})
    positive(name);
  for (const char* name : {"lock_in_rate", "dither_rate", "dither_noise"}) not_negative(name);
  if (truth.has("area") != truth.has("perimeter"))
    problems.push_back("ring_laser_gyro: area needs perimeter, and perimeter needs area");
  const int edges = truth.integer("edges");
  if (edges != 1 && edges != 2 && edges != 4)
    problems.push_back(fmt::format("ring_laser_gyro: edges = {}, but a fringe gives 1, 2 or 4 counts", edges));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

std::vector<Output> outputs(const Settings& truth) {
  refuse(truth);
  return {{.channel = "gyro",
           .kind = QuantityKind::angular_rate,
           .unit = "deg/h",
           .input = [](const Felt& felt) { return felt.rate.x; },
           .terms = {{"bias", "B", "deg/h", "output rate at rest: null shift of the two beams",
                      [](const Felt&) { return 1.0; }},
                     {"scale_factor_error", "dK/K", "ppm", "departure of the scale factor from K",
                      [](const Felt& felt) { return felt.rate.x; }},
                     {"misalignment_y", "M_y", "arcsec", "angle of the input axis toward y",
                      [](const Felt& felt) { return felt.rate.y; }},
                     {"misalignment_z", "M_z", "arcsec", "angle of the input axis toward z",
                      [](const Felt& felt) { return felt.rate.z; }}},
           .noise_prefix = ""}};
}

/// The beat phase, sampled and counted.
class Readout {
 public:
  Readout(const Settings& truth, double step, const RandomStream& random)
      : scale_factor_(ring_laser_scale_factor(truth)),
        beat_({scale_factor_, truth.number("lock_in_rate")},
              {truth.number("dither_rate"), truth.number("dither_frequency"), truth.number("dither_noise")},
              random.split("start").uniform(0), random.split("dither")),
        step_(step),
        edges_(truth.integer("edges")),
        on_block_(truth.word("readout") == "block"),
        counts_(truth.word("output") == "count") {
    last_ = read(beat_.fringes());
  }

  void operator()(std::span<double> samples) {
    for (double& sample : samples) {
      double fringes;
      beat_.advance(step_, std::span<const double>(&sample, 1), std::span<double>(&fringes, 1));
      const double now = read(fringes);
      sample = counts_ ? now - last_ : (now - last_) / (scale_factor_ * step_);
      last_ = now;
    }
  }

 private:
  double read(double fringes) const {
    if (on_block_) fringes += beat_.dither_fringes();
    return counts_ ? std::floor(fringes * edges_) : fringes;
  }

  double scale_factor_;
  BeatPhase beat_;
  double step_;
  int edges_;
  bool on_block_, counts_;
  double last_ = 0.0;
};

Recorded record(const Settings& truth, std::size_t, double step, const RandomStream& random) {
  refuse(truth);
  if (truth.word("output") == "rate" && truth.number("lock_in_rate") == 0.0 && truth.word("readout") == "case")
    return {QuantityKind::angular_rate, "deg/h", false, nullptr};
  Readout readout(truth, step, random);
  if (truth.word("output") == "rate") return {QuantityKind::angular_rate, "deg/h", false, std::move(readout)};
  return {QuantityKind::count, "pulse", true, std::move(readout)};
}

}  // namespace

extern const Model ring_laser_gyro{
    .name = "ring_laser_gyro",
    .summary = "ring laser gyro: scale factor from the ring, lock-in, sine and noisy dither, fringe counter",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 49-56",
    .constants = constants,
    .outputs = outputs,
    .physics = nullptr,
    .coefficients = nullptr,
    .record = record};

}  // namespace tumble::ring_laser_gyro
