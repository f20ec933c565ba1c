#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tumble/math/noise/streaming_bands.hpp"
#include "tumble/math/stability/streaming_allan.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/methods/allan_noise/outliers.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/even_signal.hpp"

namespace tumble::allan_noise {

/// Scatter within 400 to 800 equal blocks of a record, however long it grows.
class ScatterBlocks {
 public:
  ScatterBlocks() = default;
  /// Blocks of a part that begins at sample `start` of a record of `total` [samples]: they lie as in the whole record.
  ScatterBlocks(std::size_t start, std::size_t total);

  /// The next samples [u].
  void push(std::span<const double> values);
  /// Adds the part that follows.
  void append(const ScatterBlocks& next);
  std::size_t size() const { return size_; }  ///< of a block [samples]
  std::vector<Scatter> blocks() const;        ///< those that are full

  template <class State>
  void pass(State& state) {
    state(blocks_, size_, filled_, samples_);
  }

 private:
  std::vector<Scatter> blocks_;
  std::size_t size_ = 64, filled_ = 0, samples_ = 0;
};

/// Up to 512 segments of 4096 samples spread evenly over a record, however long it grows: all of a short one.
class SegmentSample {
 public:
  SegmentSample() = default;
  /// Segments of a part that begins at sample `start` of a record of `total` [samples]: they lie as in the whole
  /// record.
  SegmentSample(std::size_t start, std::size_t total);

  /// The next samples [u].
  void push(std::span<const double> values);
  /// Adds the part that follows.
  void append(const SegmentSample& next);
  /// One segment after the other [u].
  std::span<const double> values() const;

  template <class State>
  void pass(State& state) {
    state(kept_, position_, stride_);
  }

 private:
  std::vector<double> kept_;
  std::size_t position_ = 0, stride_ = 1;
};

/// Result of an even clock for the stamps of a record.
struct Clocked {
  double rate = 0.0;                  ///< [Hz] 0 where the samples do not determine it
  double begin = 0.0, end = 0.0;      ///< [s] times of the first and the last sample
  double given = 0.0, stamped = 0.0;  ///< [Hz] rate that was given, and that of the stamps; 0: none
  std::size_t lost = 0, gaps = 0;     ///< samples that are missing between stamps, and in how many places
  double first_gap = 0.0;             ///< [s]

  template <class State>
  void pass(State& state) {
    state(rate, begin, end, given, stamped, lost, gaps, first_gap);
  }
};
Findings findings_of(const Clocked& clocked, const std::string& label);

/// The samples of one channel on an even clock, block after block. Stamps must keep to one interval except for lost
/// samples, unless the rate is given or `timing` is "even".
class EvenStream {
 public:
  /// By the settings `rate`, if there is one, and `timing`.
  EvenStream(std::string label, const Settings& settings);

  /// Appends the samples of the next block to `values` [u], NaN for those lost before and among them.
  /// Throws Error::bad_data for a clock that runs backwards or keeps to no interval, and for an infinite sample.
  void take(const Channel& block, std::vector<double>& values);

  Clocked clocked() const;

 private:
  void by_stamps(const Channel& block, std::vector<double>& values);
  std::vector<std::size_t> lost_by_ticks(const std::vector<double>& stamps);
  double rate() const;

  std::string label_, timing_;
  double given_ = 0.0, uniform_ = 0.0, interval_ = 0.0;
  double first_ = 0.0, last_ = 0.0, first_gap_ = 0.0;
  std::size_t samples_ = 0, lost_ = 0, gaps_ = 0;
  std::vector<double> tail_;  ///< [s] latest stamps of the blocks before
  double ticked_ = 0.0;       ///< [s] interval of samples whose stamps come from a coarse clock; 0: none so far
};

/// State of the noise analysis of one channel of a record, or of a part of it, after its samples were read.
struct ChannelState {
  std::string label;
  QuantityKind kind = QuantityKind::angular_rate;
  std::size_t start = 0, total = 0;  ///< of a part: number of its first sample, samples of the whole; else 0
  StreamingAllan allan;
  StreamingNoiseBands bands;
  ScatterBlocks scatter;
  SegmentSample segments;
  OutlierSearch search;
  std::vector<Outlier> outliers;  ///< of parts that are closed, counted from the beginning of the record
  Extremes extremes;
  std::size_t samples = 0;
  Clocked clock;
  std::string failure;

  ChannelState() = default;
  ChannelState(const ChannelRun& stretch, const Settings& settings);
  /// A part: see StreamingNoiseBands.
  ChannelState(const ChannelRun& stretch, const Settings& settings, std::size_t first, std::size_t all);

  /// The two halves of the work on the next samples [u] take about the same time.
  void push_to_allan(std::span<const double> values) { allan.push(values); }
  void push_to_bands(std::span<const double> values);
  /// After the last sample: the outliers of this part.
  void close();
  /// Adds the part that follows; both are closed. Throws Error::bad_input where it does not follow.
  void append(const ChannelState& next);
  /// Curve, terms and findings of a record that is closed.
  ChannelNoise noise(const Settings& settings) const;

  template <class State>
  void pass(State& state) {
    state(label, kind, start, total, allan, bands, scatter, segments, outliers, extremes, samples, clock, failure);
  }
};

/// The channels of data of a block, of which states are to be made, with the number of each in the block.
std::vector<std::pair<ChannelRun, std::size_t>> channels_of_block(const Recording& block, const Plan& plan);

/// Throws Error::bad_input with what is wrong about the settings together.
void check_settings(const Settings& settings);
/// Throws Error::bad_input with the settings that need the record as a whole.
void refuse_unstreamable(const Settings& settings);

/// The estimate of channels whose samples passed by. Throws Error::bad_data where none could be analysed.
Estimate described_stream(const std::vector<ChannelNoise>& results, const Plan& plan);

/// Deviation and noise terms of every channel of a recording in bounded memory: about 30 MB a channel.
/// Throws Error::bad_input for an estimator or a timing that needs all samples at once.
std::vector<ChannelNoise> noise_of_stream(const StreamedEvidence& evidence);

}  // namespace tumble::allan_noise
