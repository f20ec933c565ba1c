#pragma once

#include <array>
#include <span>
#include <vector>

#include "tumble/methods/allan_noise/describe.hpp"

namespace tumble::allan_noise {

/// Looks along a record, however long it grows, for what is far from its neighbours: samples, and means over 4, 16, 64
/// and 256 samples, more than `far` times as far from the mean of the two beside them as is usual. The usual distance
/// is a quantile that 6 % outliers hardly move, of the first 65536 values of each scale or of all if there are fewer.
class OutlierSearch {
 public:
  static constexpr double far = 7.0;  ///< of Gaussian noise, one value in 4e11

  /// The next samples [u]; NaN: missing.
  void push(std::span<const double> values);
  /// Events in the order of their times; those nearer than their length are one.
  std::vector<Outlier> events();
  /// sd of a sample about its neighbours' mean [u], where 6 % outliers are not counted; 0: the samples hardly change.
  double usual() const { return scales_[0].usual; }

 private:
  struct Scale {
    std::vector<double> waiting;  ///< values before the usual distance is known, then the last two
    double usual = 0.0;
    bool measured = false;
    std::size_t first = 0;  ///< number of waiting[0] among the values of the scale
    double sum = 0.0;       ///< of the mean in the making
    std::size_t summed = 0;
  };
  void take(std::size_t scale, std::span<const double> values);
  void look(std::size_t scale);
  void measure(std::size_t scale);

  std::array<Scale, 5> scales_;
  std::vector<Outlier> events_;
};

/// Events of some length, which are knocks; the others are single samples out of place.
bool is_knock(const Outlier& event);

/// Whether they take up at most a hundredth of the record: else they are no knocks but part of the noise.
bool are_rare(const std::vector<Outlier>& events, std::size_t samples);

/// The record without the samples that are more than 4 robust sd off the median of the four beside them [u]; NaN:
/// missing. Given: values [u]; removed: how many.
std::vector<double> without_outliers(std::span<const double> values, std::size_t& removed);

/// Finds knocks and outliers of the record, and sets knocks aside where `disturbed` says so: those that are shorter
/// than the blocks that set_disturbed_aside judges.
void find_outliers(const Settings& settings, EvenSignal& signal, ChannelNoise& result);

/// Events in the parts that were set aside as disturbed are theirs; the knocks that were set aside join these parts.
void settle_outliers(ChannelNoise& result);

/// The terms of the record without its outliers, where there are any.
void add_robust_terms(const EvenSignal& signal, const Settings& settings, ChannelNoise& result);

/// Tables `knocks` and `robust`, and the findings, of all channels together.
void describe_outliers(const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
