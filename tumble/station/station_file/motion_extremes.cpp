#include "tumble/station/station_file/motion_extremes.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/shaped_noise.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::station_file {

namespace {

constexpr double segments_without = 100.0;  ///< of which one exceeds the peak of a random motion
constexpr double least_crest = 2.58;        ///< that a single value exceeds in one of a hundred

MotionExtremes swing(double amplitude, double w, double change_of_w) {
  const double size = std::abs(amplitude);
  return {.lowest = -size, .highest = size, .rate = size * w, .acceleration = size * std::hypot(w * w, change_of_w)};
}

/// A rate goes on in one direction.
MotionExtremes turn(double rate, double seconds) {
  const double way = rate * seconds;
  return {.lowest = std::min(way, 0.0), .highest = std::max(way, 0.0), .rate = rate};
}

/// The frequency goes logarithmically from one to the other.
MotionExtremes sweep(const Motion& motion, double seconds) {
  const double w = two_pi * std::max(motion.frequency, motion.to_frequency);
  const double time = motion.lasts > 0.0 ? motion.lasts : seconds;
  return swing(motion.amplitude, w, w * std::abs(std::log(motion.to_frequency / motion.frequency)) / time);
}

/// [u/s^order] standard deviation of the derivative of this order.
double deviation(const Motion& random, int order) {
  SpectralDensity psd{random.psd_frequency, random.psd};
  for (std::size_t i = 0; i < psd.density.size(); ++i)
    psd.density[i] *= std::pow(two_pi * psd.frequency[i], 2.0 * order);
  return std::sqrt(variance(psd));
}

/// A derivative of the motion, in standard deviations.
double crest(const Motion& random, int order, double seconds) {
  const double crossings = seconds * deviation(random, order + 1) / (two_pi * deviation(random, order));
  return std::max(least_crest, std::sqrt(2.0 * std::log(std::max(2.0 * segments_without * crossings, 1.0))));
}

MotionExtremes shake(const Motion& motion, double seconds, std::optional<double> clips_at) {
  const auto peak = [&](int order) {
    return deviation(motion, order) * clips_at.value_or(crest(motion, order, seconds));
  };
  const double size = peak(0);
  return {.lowest = -size,
          .highest = size,
          .rate = peak(1),
          .acceleration = peak(2),
          .crest = clips_at.value_or(crest(motion, 0, seconds))};
}

}  // namespace

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wswitch"  // a kind without extremes would have no limit

MotionExtremes extremes_of(const Motion& motion, double seconds, std::optional<double> clips_at) {
  switch (motion.kind) {
    case Motion::Kind::hold:
    case Motion::Kind::dwell:
      return {.place = motion.value};
    case Motion::Kind::ramp:
    case Motion::Kind::slew:
      return {.place = motion.to, .rate = std::abs(motion.value)};
    case Motion::Kind::rate:
      return turn(motion.value, seconds);
    case Motion::Kind::sine:
      return swing(motion.amplitude, two_pi * motion.frequency, 0.0);
    case Motion::Kind::sweep:
      return sweep(motion, seconds);
    case Motion::Kind::random:
      return shake(motion, seconds, clips_at);
  }
  return {.rate = INFINITY, .acceleration = INFINITY};  // no kind that is in the list
}

#pragma GCC diagnostic pop

}  // namespace tumble::station_file
