#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tumble/core/recording.hpp"
#include "tumble/pyramid/moments.hpp"

namespace tumble::store {

using Json = nlohmann::json;

/// Samples a block of the finest level, blocks that become one of the next, and samples a block of moments.
constexpr std::size_t finest = bar_samples, factor = 16, moment_block = block_samples;

/// Eight bytes at the begin of a file, and at its end behind the place of the description.
constexpr char signature[] = "TUMBPYR1";

/// Least and greatest of blocks of one size, less the offset of the channel.
struct Level {
  std::vector<float> low, high;
  std::vector<std::uint8_t> flags;  ///< ChannelView::Flag
};

/// The bounds of a value [u] less an offset [u], so that offset + low <= value <= offset + high in double arithmetic.
float rounded_down(double value, double offset);
/// The upper one [u].
float rounded_up(double value, double offset);

/// Grows the levels of one channel, sample after sample.
class Levels {
 public:
  /// `values` [SI]; `times` [s]: null for an evenly sampled channel, whose unit of time is the sample.
  void add(const double* values, const double* times, std::size_t count);
  /// Completes all levels up to the last sample. More may be added afterwards.
  void finish();

  std::size_t samples() const { return samples_ + pending_.size(); }
  double offset() const { return offset_; }                                      ///< [SI]
  const std::vector<Level>& levels() const { return levels_; }                   ///< of 64, 1024 ... samples
  const std::vector<std::vector<Moments>>& moments() const { return moments_; }  ///< of 1024, 16384 ... samples

 private:
  void take(const double* values, const double* times, std::size_t count);
  bool take_whole(const double* values);
  void put_bar(double least, double greatest, std::uint8_t flags);
  void grow();
  void reopen();

  std::vector<double> pending_, pending_times_;  ///< behind the last whole block of moments
  std::size_t samples_ = 0;                      ///< in whole blocks of moments
  bool finished_ = false;                        ///< the levels have the pending ones too
  double offset_ = 0.0;
  bool offset_known_ = false;
  std::vector<Level> levels_;
  std::vector<std::vector<Moments>> moments_;
};

/// Description of a recording as JSON, as a file of a pyramid has it, without the numbers of samples.
Json description_of(const Recording& recording);
Recording recording_of(const Json& description);

}  // namespace tumble::store
