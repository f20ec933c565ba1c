#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"

namespace tumble {

/// How long the samples of one channel last in one part of a record, on an even clock.
struct ChannelExtent {
  std::string label;
  std::size_t samples = 0;        ///< those that are missing among them are counted
  double rate = 0.0;              ///< [Hz]
  double begin = 0.0, end = 0.0;  ///< [s] times of the first and the last sample, on the clock of the part

  template <class State>
  void pass(State& state) {
    state(label, samples, rate, begin, end);
  }
};

/// Measures a part that is handed out block after block.
class NoiseExtent {
 public:
  explicit NoiseExtent(const Plan& plan);
  ~NoiseExtent();
  void push(const Recording& block);
  std::vector<ChannelExtent> channels() const;

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

/// Where the samples of one channel of a part lie in the whole record.
struct PlaceInRecord {
  std::size_t start = 0, total = 0;  ///< number of the first sample; samples of the whole
  std::size_t lost_before = 0;       ///< samples that are missing between the part before and this one: they come first

  template <class State>
  void pass(State& state) {
    state(start, total, lost_before);
  }
};

/// State of the method allan_noise for one part of a record that many processes work through: the noise of all parts
/// together is that of the whole record, to rounding, except for outliers and knocks, which are searched in each part
/// by itself. Its size, about 1 MB a channel, does not grow with that of the part.
///
/// See: docs/fleet.md
class NoisePart {
 public:
  /// Given: a plan of the method allan_noise; the place of each channel. Throws Error::bad_input for settings that look
  /// at the record as a whole, and for another method.
  NoisePart(const Plan& plan, std::vector<PlaceInRecord> places);
  NoisePart(NoisePart&&) noexcept;
  NoisePart& operator=(NoisePart&&) noexcept;
  ~NoisePart();

  /// The next samples of all channels. Throws Error::bad_data where the block has other channels than the places.
  void push(const Recording& block);
  /// After the last block.
  void close();

  /// Joins the part that follows; both are closed. Throws Error::bad_input where it does not follow.
  void append(const NoisePart& next);
  /// Parameters, curves and findings. Throws Error::bad_data where no channel can be analysed.
  Estimate estimate(const Plan& plan) const;

  /// For another process of the same version.
  std::string bytes() const;
  /// Throws Error::bad_file.
  static NoisePart from_bytes(std::string_view bytes);

 private:
  struct Work;
  explicit NoisePart(std::unique_ptr<Work> work);
  std::unique_ptr<Work> work_;
};

}  // namespace tumble
