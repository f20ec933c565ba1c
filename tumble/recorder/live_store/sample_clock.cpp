#include "tumble/recorder/live_store/sample_clock.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace tumble::live_store {

namespace {

constexpr double reference_span = 10.0;    ///< [s] in which the least late sample is looked for
constexpr double least_early = 0.25;       ///< [s] by which no clock of a computer is wrong
constexpr double longest_wait = 60.0;      ///< [s] of a sample on its way
constexpr double least_late = 0.5;         ///< [s] before lost rounds of a counter are thought of
constexpr double decided_after = 10.0;     ///< [s] of samples that are all late, at most
constexpr double long_line = 2.0;          ///< [s] of an earliest line that is trusted
constexpr std::uint64_t long_count = 100;  ///< samples of it
constexpr double most_doubt = 0.01;        ///< of the interval by an earliest line
constexpr std::uint64_t fewest = 20;       ///< samples before a line is trusted

}  // namespace

std::uint64_t SampleClock::shifted(std::uint64_t sequence) const {
  std::uint64_t shift = 0;
  for (const Restart& one : restarts_)
    if (sequence >= one.from) shift += one.shift;
  return sequence + shift;
}

bool SampleClock::can_judge() const { return count_ >= fewest && before_.holds && slope() > 0.0; }

double SampleClock::lateness(std::uint64_t sequence, double arrival) const {
  const auto against = [&](const Reference& reference) {
    return arrival - reference.arrival -
           slope() * (static_cast<double>(sequence) - static_cast<double>(reference.sequence));
  };
  return now_.holds ? std::max(against(before_), against(now_)) : against(before_);
}

/// Eight standard deviations of the slope, over the way from the reference.
double SampleClock::doubt(std::uint64_t sequence) const {
  return 8.0 * slope_sd() * std::abs(static_cast<double>(sequence) - static_cast<double>(before_.sequence));
}

void SampleClock::refer_to(std::uint64_t sequence, double arrival) {
  const double interval = slope() > 0.0 ? slope() : declared_ > 0.0 ? 1.0 / declared_ : 0.0;
  const auto is_less_late = [&] {
    return arrival - now_.arrival < interval * (static_cast<double>(sequence) - static_cast<double>(now_.sequence));
  };
  if (now_.holds && arrival - now_.since > reference_span) before_ = std::exchange(now_, {});
  if (!now_.holds)
    now_ = {arrival, arrival, sequence, true};
  else if (is_less_late())
    now_.arrival = arrival, now_.sequence = sequence;
  if (!before_.holds) before_ = now_;
}

/// The sample is `late` [s], which may be negative, only by its number: it is put where its arrival says.
void SampleClock::restart(const Sample& sample, double late) {
  const std::uint64_t step = std::max<std::uint64_t>(step_, 1), sequence = shifted(sample.number);
  const double steps = std::round((static_cast<double>(sequence) + late / slope() - static_cast<double>(first_)) /
                                  static_cast<double>(step));
  const auto wanted = first_ + step * static_cast<std::uint64_t>(std::max(0.0, steps));
  restarts_.push_back({sample.number, std::max(wanted, last_ + step) - sequence});
  in_epoch_ = 0;
  mean_x_ = mean_t_ = 0.0;
  now_ = before_ = {};
}

void SampleClock::wait(const Sample& sample, double late) {
  least_late_ = first_late_ = late;
  late_.push_back(sample);
}

void SampleClock::add(std::uint64_t number, double arrival, std::optional<double> device) {
  const std::uint64_t stretch = number / numbers_of_a_stretch;
  const bool anew = std::exchange(stretch_, stretch) != stretch && count_ + late_.size() > 0;
  number %= numbers_of_a_stretch;
  const Sample sample{number, arrival, device};
  if (anew) {
    decide(true);
    if (can_judge()) {
      anew_ = true;
      return wait(sample, lateness(shifted(number), arrival));
    }
  }
  if (!late_.empty()) {
    least_late_ = std::min(least_late_, lateness(shifted(number), arrival));
    late_.push_back(sample);
    return decide(false);
  }
  const std::uint64_t sequence = shifted(number);
  if (can_judge() && sequence > last_) {
    const double interval = slope(), late = lateness(sequence, arrival);
    const double round = std::min(modulus_ * interval, longest_wait);
    const double early_by = -std::max(least_early, 3.0 * interval);
    const double late_by = std::max({least_late, 3.0 * interval, round / 8.0});
    if (late < early_by && late < early_by - doubt(sequence)) {
      restart(sample, late);
    } else if (late > late_by && late > late_by + doubt(sequence)) {
      return wait(sample, late);
    }
  }
  take(sample);
}

/// Samples that waited on their way are followed by others that are less late; where numbers are missing, none is.
void SampleClock::decide(bool all) {
  if (late_.empty()) return;
  const bool waited = !anew_ && least_late_ < 0.5 * first_late_;
  const double span = late_.back().arrival - late_.front().arrival;
  const double enough =
      anew_ ? (late_.size() < fewest ? decided_after : 1.0) : std::clamp(0.5 * first_late_, 1.0, decided_after);
  if (!all && !waited && span < enough) return;
  const auto samples = std::exchange(late_, {});
  anew_ = false;
  if (!waited) restart(samples.front(), least_late_);
  for (const Sample& sample : samples) take(sample);
}

void SampleClock::take(const Sample& sample) {
  const std::uint64_t sequence = shifted(sample.number);
  const double arrival = sample.arrival;
  if (count_++ == 0) {
    first_ = sequence;
    origin_ = arrival;
  } else if (sequence <= last_) {
    backward_ = true;
    return;
  }
  refer_to(sequence, arrival);
  if (declared_ > 0.0) lay(sequence, arrival, 1.0 / declared_);
  last_ = sequence;
  step_ = std::gcd(step_, sequence - first_);
  if (const auto device = sample.device) {
    if (!device_first_) device_first_ = device, device_from_ = sequence;
    device_last_ = device, device_to_ = sequence;
  }
  const double x = static_cast<double>(sequence - first_), t = arrival - origin_, n = static_cast<double>(++in_epoch_);
  line_.add(x, t);
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

/// By the earliest line, which samples that waited do not move, where it is long enough; else by all samples.
double SampleClock::interval_by_arrival() const {
  const bool is_long = line_.width() * line_.slope() > long_line && line_.width() > static_cast<double>(long_count);
  return is_long ? line_.slope() : slope();
}

double SampleClock::arrival_rate() const {
  const double interval = interval_by_arrival();
  return count_ > 2 && interval > 0.0 ? 1.0 / interval : 0.0;
}

void SampleClock::settle() {
  decide(true);
  step_ = std::max<std::uint64_t>(step_, 1);
  const double arrival = interval_ = interval_by_arrival(), resolution = 1e-9 * std::abs(arrival);
  const double doubt = arrival == slope() ? 4.0 * slope_sd() : std::min(4.0 * slope_sd(), most_doubt * arrival);
  const auto agrees = [&](double interval) {
    return interval > 0.0 && (count_ < 3 || std::abs(interval - arrival) <= doubt + resolution);
  };
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
  if (!placed_) lay(shifted(number % numbers_of_a_stretch), arrival, interval_);
}

std::size_t SampleClock::index(std::uint64_t number) const {
  return static_cast<std::size_t>((shifted(number % numbers_of_a_stretch) - first_) / step_);
}
std::size_t SampleClock::length() const { return static_cast<std::size_t>((last_ - first_) / step_) + 1; }
double SampleClock::rate() const { return 1.0 / (interval_ * static_cast<double>(step_)); }

}  // namespace tumble::live_store
