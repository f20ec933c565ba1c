#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/even_signal.hpp"

namespace tumble::allan_noise {

/// Scatter within 400 to 800 equal blocks of a record, however long it grows.
class ScatterBlocks {
 public:
  /// The next samples [u].
  void push(std::span<const double> values);
  std::size_t size() const { return size_; }  ///< of a block [samples]
  std::vector<Scatter> blocks() const;        ///< those that are full

 private:
  std::vector<Scatter> blocks_;
  std::size_t size_ = 64, filled_ = 0, samples_ = 0;
};

/// Up to 512 segments of 4096 samples spread evenly over a record, however long it grows: all of a short one.
class SegmentSample {
 public:
  /// The next samples [u].
  void push(std::span<const double> values);
  /// One segment after the other [u].
  std::span<const double> values() const;

 private:
  std::vector<double> kept_;
  std::size_t position_ = 0, stride_ = 1;
};

/// The samples of one channel on an even clock, block after block. Stamps must keep to one interval but for lost
/// samples, unless the rate is given or `timing` is "even".
class EvenStream {
 public:
  /// Given: rate [Hz]; 0: that of the stamps.
  EvenStream(std::string label, double rate, std::string timing);

  /// Appends the samples of the next block to `values` [u], NaN for those lost before and among them.
  /// Throws Error::bad_data for a clock that runs backwards or keeps to no interval, and for an infinite sample.
  void take(const Channel& block, std::vector<double>& values);

  double rate() const;                     ///< [Hz] 0 where it cannot be told
  double begin() const { return first_; }  ///< [s]
  Findings findings() const;

 private:
  void by_stamps(const Channel& block, std::vector<double>& values);

  std::string label_, timing_;
  double given_ = 0.0, uniform_ = 0.0, interval_ = 0.0;
  double first_ = 0.0, last_ = 0.0, first_gap_ = 0.0;
  std::size_t samples_ = 0, lost_ = 0, gaps_ = 0;
};

/// Deviation and noise terms of every channel of a recording in bounded memory: about 30 MB a channel.
/// Throws Error::bad_input for an estimator or a timing that needs all samples at once.
std::vector<ChannelNoise> noise_of_stream(const StreamedEvidence& evidence);

}  // namespace tumble::allan_noise
