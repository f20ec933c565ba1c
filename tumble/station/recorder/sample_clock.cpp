#include "tumble/station/recorder/sample_clock.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tumble::recorder {

std::uint64_t SampleClock::shifted(std::uint64_t sequence) const {
  std::uint64_t shift = 0;
  for (const Restart& restart : restarts_)
    if (sequence >= restart.from) shift = restart.shift;
  return sequence + shift;
}

/// Frames that were lost took their time.
bool SampleClock::restarts(std::uint64_t sequence, double arrival) const {
  if (count_ < 100 || sequence <= last_ || !(slope() > 0.0)) return false;
  const double waited = (arrival - arrival_) / slope(), jump = static_cast<double>(sequence - last_);
  return jump > 4.0 * waited + 1000.0;
}

void SampleClock::add(std::uint64_t number, double arrival, std::optional<double> device) {
  std::uint64_t sequence = shifted(number);
  if (restarts(sequence, arrival)) {
    const auto place = static_cast<std::uint64_t>(std::max(0.0, std::round((arrival - origin_) / slope())));
    restarts_.push_back({number, std::max(first_ + place, last_ + 1) - number});
    sequence = shifted(number);
    in_epoch_ = 0;
    mean_x_ = mean_t_ = 0.0;
  }
  arrival_ = arrival;
  if (count_++ == 0) {
    first_ = sequence;
    origin_ = arrival;
  } else if (sequence <= last_) {
    backward_ = true;
    return;
  }
  if (declared_ > 0.0) lay(sequence, arrival, 1.0 / declared_);
  last_ = sequence;
  step_ = std::gcd(step_, sequence - first_);
  if (device) {
    if (!device_first_) device_first_ = device, device_from_ = sequence;
    device_last_ = device, device_to_ = sequence;
  }
  const double x = static_cast<double>(sequence - first_), t = arrival - origin_, n = static_cast<double>(++in_epoch_);
  const double dx = x - mean_x_, dt = t - mean_t_;
  mean_x_ += dx / n;
  mean_t_ += dt / n;
  xx_ += dx * (x - mean_x_);
  xt_ += dx * (t - mean_t_);
  tt_ += dt * (t - mean_t_);
}

double SampleClock::slope() const { return xx_ > 0.0 ? xt_ / xx_ : 0.0; }

double SampleClock::jitter() const {
  return count_ > 2 ? std::sqrt(std::max(tt_ - slope() * xt_, 0.0) / static_cast<double>(count_ - 2)) : 0.0;
}

/// Samples that wait together for a packet are late together: as many of them count once as arrive within the jitter.
double SampleClock::slope_sd() const {
  const double together = slope() > 0.0 ? std::max(1.0, 2.0 * jitter() / slope()) : 1.0;
  return xx_ > 0.0 ? jitter() * std::sqrt(together / xx_) : 0.0;
}

double SampleClock::device_slope() const {
  if (!device_first_ || device_to_ == device_from_) return 0.0;
  return (*device_last_ - *device_first_) / static_cast<double>(device_to_ - device_from_);
}

double SampleClock::arrival_rate() const { return count_ > 2 && slope() > 0.0 ? 1.0 / slope() : 0.0; }

void SampleClock::settle() {
  step_ = std::max<std::uint64_t>(step_, 1);
  const double resolution = 1e-9 * std::abs(slope());
  const auto agrees = [&](double interval) {
    return interval > 0.0 && (count_ < 3 || std::abs(interval - slope()) <= 4.0 * slope_sd() + resolution);
  };
  interval_ = slope();
  if (const double device = device_slope(); agrees(device)) interval_ = device;
  placed_ = declared_ > 0.0 && agrees(1.0 / declared_);
  if (placed_) interval_ = 1.0 / declared_;
  laid_ = laid_ && placed_;
  const std::uint64_t most = 4 * count_ + 1000;  // more are missing than a recording should hold
  even_ = interval_ > 0.0 && !backward_ && count_ > 1 && (last_ - first_) / step_ < most;
}

void SampleClock::lay(std::uint64_t sequence, double arrival, double interval) {
  const double begin = arrival - static_cast<double>(sequence - first_) * interval;
  begin_ = laid_ ? std::min(begin_, begin) : begin;
  laid_ = true;
}

void SampleClock::place(std::uint64_t number, double arrival) {
  if (!placed_) lay(shifted(number), arrival, interval_);
}

std::size_t SampleClock::index(std::uint64_t number) const {
  return static_cast<std::size_t>((shifted(number) - first_) / step_);
}
std::size_t SampleClock::length() const { return static_cast<std::size_t>((last_ - first_) / step_) + 1; }
double SampleClock::rate() const { return 1.0 / (interval_ * static_cast<double>(step_)); }

}  // namespace tumble::recorder
