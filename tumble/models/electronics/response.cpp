#include "tumble/models/electronics/response.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>

#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::electronics {
namespace {

void require(bool good, const char* what) {
  if (!good) throw Error(Error::Kind::bad_input, what);
}

/// The parabola through the last three samples, as a function of the time since the sample before last in steps:
/// constant + slope t + curvature t^2.
struct Parabola {
  double constant, slope, curvature;
};

/// The last three samples, newest last.
struct History {
  double oldest = 0.0, middle = 0.0, newest = 0.0;
  bool begun = false;

  Parabola with(double sample) {
    if (!begun) oldest = middle = newest = sample;
    begun = true;
    oldest = middle;
    middle = newest;
    newest = sample;
    const double curvature = 0.5 * (newest - 2.0 * middle + oldest);
    return {middle, newest - middle - curvature, curvature};
  }
};

/// What a free motion becomes after one step: y = yy y0 + yv v0, v = vy y0 + vv v0.
struct Transition {
  double yy, yv, vy, vv;
};

/// Of y'' + 2 zeta w y' + w^2 y = 0, w in [rad/step].
Transition free_motion(double w, double zeta) {
  if (std::abs(zeta - 1.0) < 1e-6) {  // both roots together: t exp(-w t) instead of the difference of two near equals
    const double decay = std::exp(-w);
    return {decay * (1.0 + w), decay, -decay * w * w, decay * (1.0 - w)};
  }
  const std::complex<double> root = std::sqrt(std::complex<double>(zeta * zeta - 1.0, 0.0));
  const std::complex<double> p = w * (-zeta + root), q = w * (-zeta - root);
  const std::complex<double> ep = std::exp(p), eq = std::exp(q), gap = p - q;
  return {((p * eq - q * ep) / gap).real(), ((ep - eq) / gap).real(), (p * q * (eq - ep) / gap).real(),
          ((p * ep - q * eq) / gap).real()};
}

/// State of a loop in steps of its own time: w in [rad/step].
class SecondOrder {
 public:
  SecondOrder(double w, double zeta) : w_(w), zeta_(zeta), free_(free_motion(w, zeta)) {}

  double next(double sample) {
    if (!inputs_.begun) y_ = sample;
    const Parabola u = inputs_.with(sample);
    // the forced motion is a parabola as well: c0 + c1 t + c2 t^2
    const double c2 = u.curvature, c1 = u.slope - 4.0 * zeta_ * c2 / w_;
    const double c0 = u.constant - 2.0 * zeta_ * c1 / w_ - 2.0 * c2 / (w_ * w_);
    const double y = y_ - c0, v = v_ - c1;
    y_ = c0 + c1 + c2 + free_.yy * y + free_.yv * v;
    v_ = c1 + 2.0 * c2 + free_.vy * y + free_.vv * v;
    return y_;
  }

 private:
  double w_, zeta_;
  Transition free_;
  History inputs_;
  double y_ = 0.0, v_ = 0.0;
};

class FirstOrder {
 public:
  explicit FirstOrder(double steps) : time_(steps), decay_(std::exp(-1.0 / steps)) {}

  double next(double sample) {
    if (!inputs_.begun) y_ = sample;
    const Parabola u = inputs_.with(sample);
    const double c2 = u.curvature, c1 = u.slope - 2.0 * time_ * c2, c0 = u.constant - time_ * c1;
    y_ = c0 + c1 + c2 + decay_ * (y_ - c0);
    return y_;
  }

 private:
  double time_, decay_;  ///< [step], [1]
  History inputs_;
  double y_ = 0.0;
};

/// Whole pulses and the part of the next one.
class Counter {
 public:
  Counter(double step, double start_phase) : step_(step), phase_(start_phase) {}

  double next(double rate) {
    phase_ += rate * step_;
    const double pulses = std::floor(phase_);
    phase_ -= pulses;
    return pulses;
  }

 private:
  double step_, phase_;
};

template <class State>
Response sample_by_sample(State state) {
  return [state](std::span<double> samples) mutable {
    for (double& sample : samples) sample = state.next(sample);
  };
}

}  // namespace

Response in_series(std::vector<Response> stages) {
  std::erase_if(stages, [](const Response& stage) { return !stage; });
  if (stages.empty()) return nullptr;
  if (stages.size() == 1) return stages.front();
  return [stages = std::move(stages)](std::span<double> samples) {
    for (const Response& stage : stages) stage(samples);
  };
}

Response second_order_loop(double natural_frequency, double damping_ratio, double step) {
  require(natural_frequency > 0.0, "natural_frequency of a loop must be positive");
  require(damping_ratio > 0.0, "damping_ratio of a loop must be positive");
  require(step > 0.0, "the step of a loop must be positive");
  return sample_by_sample(SecondOrder(two_pi * natural_frequency * step, damping_ratio));
}

Response first_order_loop(double time_constant, double step) {
  require(time_constant > 0.0, "time_constant of a loop must be positive");
  require(step > 0.0, "the step of a loop must be positive");
  return sample_by_sample(FirstOrder(time_constant / step));
}

Response clip(double low, double high) {
  require(low < high, "the lower limit of the range must lie below the upper one");
  return [=](std::span<double> samples) {
    for (double& sample : samples) sample = std::clamp(sample, low, high);
  };
}

Response dead_zone(double low, double high) {
  require(low <= 0.0 && high >= 0.0, "a dead zone must contain zero");
  return [=](std::span<double> samples) {
    for (double& sample : samples)
      if (sample >= low && sample <= high) sample = 0.0;
  };
}

Response quantiser(double quantum) {
  require(quantum > 0.0, "resolution must be positive");
  return [=](std::span<double> samples) {
    for (double& sample : samples) sample = quantum * std::round(sample / quantum);
  };
}

Response scaled(double factor) {
  return [=](std::span<double> samples) {
    for (double& sample : samples) sample *= factor;
  };
}

Response pulse_counter(double step, double start_phase) {
  require(step > 0.0, "the step of a pulse counter must be positive");
  return sample_by_sample(Counter(step, start_phase));
}

}  // namespace tumble::electronics
