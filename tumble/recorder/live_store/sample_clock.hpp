#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/recorder/live_store/earliest_line.hpp"

namespace tumble::live_store {

/// Numbers of samples behind a restart of the counter, where nobody knows how many are missing, are higher by so many.
inline constexpr std::uint64_t numbers_of_a_stretch = std::uint64_t{1} << 40;

/// When the samples of a channel were taken, from their sequence numbers and the times of their arrival.
///
/// The device counts evenly, and every sample arrives late: the interval between counts is the slope of a straight line
/// through arrival against sequence number, and the first sample was complete where no arrival is earlier than the
/// line; its time is the begin of what it is the mean or the increment of, one interval before.
///
/// Numbers and arrival may contradict each other: a unit that is switched on again counts from zero, and a counter of
/// few bits does not see that it has gone round. A sample that would arrive before it was taken, or one after which all
/// others are late, begins a new stretch of numbers: the even clock goes on, by whole intervals. So does one behind a
/// restart of the counter that the stream has seen; the least late of the next samples places it. Samples that waited
/// somewhere on their way are late too, and arrive together: they change nothing.
///
/// A declared rate, or that of the clock of the device, holds as long as the line does not contradict it by more than
/// four of its standard deviations, or 1 % where the earliest arrivals alone give the line.
class SampleClock {
 public:
  /// `declared` [Hz] of the sequence, 0: not; `modulus` after which the counter of the device begins again.
  explicit SampleClock(double declared = 0.0, double modulus = 4294967296.0) : declared_(declared), modulus_(modulus) {}
  /// A sample with its number, its arrival [s], and the time of the device [s].
  void add(std::uint64_t sequence, double arrival, std::optional<double> device);
  /// Decides on the interval.
  void settle();
  /// Whether the earliest line is known after settle(): it is while the declared rate holds.
  bool placed() const { return placed_; }
  /// Else, after settle(), a second time through the samples, arrival [s]: the earliest line.
  void place(std::uint64_t sequence, double arrival);

  std::uint64_t count() const { return count_; }
  /// Whether the samples lie on an even clock, of which lost ones are missing.
  bool even() const { return even_; }
  std::size_t length() const;  ///< [samples] of the even clock, lost ones too
  std::size_t index(std::uint64_t sequence) const;
  Timeline timeline() const { return {begin_ - 1.0 / rate(), rate(), nullptr}; }
  double rate() const;                           ///< [Hz] of the samples
  double arrival_rate() const;                   ///< [Hz] of the sequence by the line; 0: too few samples
  double declared() const { return declared_; }  ///< [Hz]
  double jitter() const;                         ///< [s] rms of the arrival about the line

 private:
  double slope() const;                ///< [s] a count
  double slope_sd() const;             ///< [s]
  double interval_by_arrival() const;  ///< [s] a count
  double device_slope() const;         ///< [s] a count; 0 without a clock of the device

  struct Sample {
    std::uint64_t number = 0;
    double arrival = 0.0;               ///< [s]
    std::optional<double> device = {};  ///< [s]
  };
  /// From this number on, numbers are shifted by so many more.
  struct Restart {
    std::uint64_t from = 0, shift = 0;
  };
  /// The sample of a stretch of time that was the least late.
  struct Reference {
    double since = 0.0, arrival = 0.0;  ///< [s]
    std::uint64_t sequence = 0;
    bool holds = false;
  };
  std::uint64_t shifted(std::uint64_t sequence) const;
  void lay(std::uint64_t sequence, double arrival, double interval);
  bool can_judge() const;
  double lateness(std::uint64_t sequence, double arrival) const;  ///< [s] against the least late of the last seconds
  double doubt(std::uint64_t sequence) const;                     ///< [s] in it
  void refer_to(std::uint64_t sequence, double arrival);          ///< [s]
  void restart(const Sample& sample, double late);                ///< [s]
  void wait(const Sample& sample, double late);                   ///< [s]
  void decide(bool all);
  void take(const Sample& sample);

  std::vector<Sample> late_;  ///< of which it is not decided whether they waited, or others before them are missing
  double least_late_ = 0.0;   ///< [s] of them
  double first_late_ = 0.0;   ///< [s] the first of them
  bool anew_ = false;         ///< they are behind a restart of the counter
  Reference now_, before_;
  EarliestLine line_;
  std::vector<Restart> restarts_;
  std::uint64_t first_ = 0, last_ = 0, step_ = 0, count_ = 0;
  std::uint64_t stretch_ = 0;   ///< of the last number
  std::uint64_t in_epoch_ = 0;  ///< samples since the last restart: the line has one slope, and an offset for each
  double mean_x_ = 0.0, mean_t_ = 0.0, xx_ = 0.0, xt_ = 0.0, tt_ = 0.0;
  double origin_ = 0.0;  ///< [s] the first arrival
  std::optional<double> device_first_, device_last_;
  std::uint64_t device_from_ = 0, device_to_ = 0;
  double declared_ = 0.0, modulus_ = 0.0, interval_ = 0.0, begin_ = 0.0;
  bool even_ = false, placed_ = false, laid_ = false, backward_ = false;
};

}  // namespace tumble::live_store
