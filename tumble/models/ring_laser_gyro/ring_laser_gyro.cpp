#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "tumble/models/lock_in.hpp"
#include "tumble/models/model.hpp"
#include "tumble/models/sagnac.hpp"
#include "tumble/units/error.hpp"

namespace tumble::ring_laser_gyro {
namespace {

using Input::w_x, Input::w_y, Input::w_z;

std::vector<Option> constants() {
  return {
      quantity("scale_factor", "pulse/arcsec").above(0).says("K: fringes for each angle; default: 4 A/(lambda L)"),
      quantity("wavelength", "nm").above(0).otherwise("632.8 nm").says("lambda, in vacuum"),
      word("shape", {"triangle", "square"}).otherwise("triangle").says("shape of the ring"),
      quantity("side", "mm").above(0).otherwise("100 mm").says("side of the ring; area and perimeter replace it"),
      quantity("area", "cm^2").above(0).says("A: area inside the ring; needs perimeter"),
      quantity("perimeter", "mm").above(0).says("L: perimeter of the ring; needs area"),
      quantity("lock_in_rate", "deg/s")
          .at_least(0)
          .otherwise("0 deg/s")
          .says("W_L: half width of the dead band without dither"),
      quantity("dither_rate", "deg/s").at_least(0).otherwise("0 deg/s").says("W_A: peak rate of the dither; 0: none"),
      quantity("dither_frequency", "Hz").above(0).otherwise("400 Hz").says("f_D: frequency of the dither"),
      quantity("dither_noise")
          .at_least(0)
          .otherwise("0")
          .says("sd of the angle of each turn-around, relative to the angle"),
      word("readout", {"case", "block"})
          .otherwise("case")
          .says("support of the readout: on the block its output contains the dither angle"),
      word("output", {"count", "rate"}).otherwise("count").says("counts in each interval, or the mean rate over it"),
      integer("edges").between(1, 4).otherwise("1").says("counts for each fringe: 1, 2 or 4")};
}

void refuse(const Settings& truth) {
  Problems problems;
  if (truth.has("area") != truth.has("perimeter"))
    problems.push_back("ring_laser_gyro: area needs perimeter, and perimeter needs area");
  if (truth.integer("edges") == 3)
    problems.push_back("ring_laser_gyro: edges = 3, but a fringe gives 1, 2 or 4 counts");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

std::vector<Output> outputs(const Settings& truth) {
  refuse(truth);
  return {{.channel = "gyro",
           .kind = QuantityKind::angular_rate,
           .unit = "deg/h",
           .input = w_x,
           .terms = {{"bias", "B", "deg/h", "output rate at rest: null shift of the two beams", 1.0},
                     {"scale_factor_error", "dK/K", "ppm", "departure of the scale factor from K", w_x},
                     {"misalignment_y", "M_y", "arcsec", "angle of the input axis toward y", w_y},
                     {"misalignment_z", "M_z", "arcsec", "angle of the input axis toward z", w_z}},
           .noise_prefix = ""}};
}

/// The beat phase, sampled and counted.
class Readout {
 public:
  Readout(const Settings& truth, double step, const RandomStream& random)
      : scale_factor_(ring_laser_scale_factor(truth)),
        beat_({scale_factor_, truth.number("lock_in_rate")},
              {truth.number("dither_rate"), truth.number("dither_frequency"), truth.number("dither_noise")},
              random.split("start").uniform(0), random.split("dither"), std::pow(truth.number("angle_random_walk"), 2)),
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
  if (truth.word("output") == "rate") return {QuantityKind::angular_rate, "deg/h", false, readout};
  return {QuantityKind::count, "pulse", true, readout};
}

}  // namespace

extern const Model ring_laser_gyro{
    .name = "ring_laser_gyro",
    .summary = "ring laser gyro: scale factor from the ring, lock-in, sine and noisy dither, fringe counter",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 49-56",
    .constants = constants,
    .outputs = outputs,
    .record = record};

}  // namespace tumble::ring_laser_gyro
