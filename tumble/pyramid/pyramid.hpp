#pragma once

#include <any>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/core/read_options.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/formats/random_access.hpp"

namespace tumble {

/// Builds the pyramid of a recording in one pass and writes it to `path`, whole or not at all. Of every channel it
/// holds the least and the greatest of 64, 1024, 16384 ... samples, and moments of 1024, 16384 ... from which the
/// statistics of any span follow. Of a format that can be read only from the beginning it holds the samples too, and of
/// stamped channels their stamps.
///
/// Returned  waits for the SHA-256 of the recording, lower-case hex, which another thread works out; of a folder empty
/// Throws    Error::bad_file, and as the readers do
std::function<std::string()> build_pyramid(const std::string& recording, const ReadOptions& options,
                                           const std::string& path, const Progress& progress);

/// Description of a channel in a pyramid.
struct PyramidChannel {
  std::string name;
  QuantityKind kind = QuantityKind::other;
  Unit unit;
  std::size_t samples = 0;
  double first = 0.0, last = 0.0;  ///< [s] times of the first and the last sample
  bool stamped = false;
};

/// A stretch of one channel as it is drawn: bars, or samples where there are few. Values are in the unit asked for.
struct ChannelView {
  enum Flag : std::uint8_t { missing = 1, constant = 2 };  ///< of a bar: some are missing; all others are equal
  bool samples = false;                                    ///< true: `values` are the samples themselves
  std::size_t first = 0;                                   ///< number of the first sample
  std::size_t block = 1;                                   ///< samples a bar; bars begin at multiples of it
  double offset = 0.0;                                     ///< to be added to low and high [unit]
  double start = 0.0, step = 0.0;  ///< [s] of the first bar or sample, and between neighbours; step 0: see times
  std::vector<double> times;       ///< [s] of the first sample of each
  std::vector<float> low, high;    ///< [unit] less the offset, rounded outward; NaN: all are missing
  std::vector<std::uint8_t> flags;
  std::vector<double> values;  ///< [unit]
};

/// Statistics of all samples of a span, missing ones excluded.
struct SpanStatistics {
  std::size_t samples = 0, missing = 0;
  double first = 0.0, last = 0.0;                             ///< [s] times of the first and the last sample
  double mean = 0.0, sd = 0.0, minimum = 0.0, maximum = 0.0;  ///< [SI]
  double slope = 0.0;                                         ///< of the straight line by least squares [SI/s]
};

/// A recording that is being made (live_recording.hpp), at a moment.
struct PyramidMoment {
  Recording header;
  std::vector<PyramidChannel> channels;
  std::any store;  ///< store::LiveChannels
};

/// A pyramid that is open. Several threads may ask at once.
class Pyramid {
 public:
  /// `samples` reads the recording itself; empty where the pyramid holds its samples. Throws Error::bad_file.
  Pyramid(const std::string& path, SampleReader samples);
  explicit Pyramid(PyramidMoment moment);
  Pyramid(Pyramid&&) noexcept;
  Pyramid& operator=(Pyramid&&) noexcept;
  ~Pyramid();

  /// Everything of the recording but the samples: instrument, marks, meta. Its channels are empty.
  const Recording& header() const;
  const std::vector<PyramidChannel>& channels() const;

  /// Number of the first sample at or after `time` [s]; the number of samples if all are before it.
  std::size_t index_at(std::size_t channel, double time) const;
  /// Time of a sample [s].
  double time(std::size_t channel, std::size_t sample) const;
  /// Appends `count` samples [SI] from `first` on. Throws Error::bad_file.
  void read(std::size_t channel, std::size_t first, std::size_t count, std::vector<double>& to) const;
  /// The span from `from` to `to` [s], with a neighbour on each side, in about `pixels` bars [1].
  ChannelView view(std::size_t channel, double from, double to, std::size_t pixels, const Unit& unit) const;
  /// Statistics of samples `first` up to but not including `end` [1].
  ///
  /// Accuracy  mean, sd and slope 1e-12 of the scatter and the size of the values; minimum and maximum exact
  SpanStatistics statistics(std::size_t channel, std::size_t first, std::size_t end) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace tumble
