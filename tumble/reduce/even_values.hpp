#pragma once

#include <cstddef>
#include <iterator>
#include <vector>

#include "tumble/core/channel.hpp"

namespace tumble {

/// Evenly spaced values, scaled: a view of those of a channel, or a copy with NaN for samples that the channel lacks.
/// The channel must outlive the view.
class EvenValues {
 public:
  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using difference_type = std::ptrdiff_t;
    using value_type = double;

    Iterator() = default;
    /// Given: value [unit of the channel], scale [SI for one unit of the channel].
    Iterator(const double* value, double scale) : value_(value), scale_(scale) {}
    /// The value [SI].
    double operator*() const { return scale_ * *value_; }
    Iterator& operator++() { return ++value_, *this; }
    Iterator operator++(int) { return {value_++, scale_}; }
    bool operator==(const Iterator& other) const { return value_ == other.value_; }

   private:
    const double* value_ = nullptr;
    double scale_ = 1.0;
  };

  EvenValues() = default;
  /// Given     values   [SI of the channel]
  ///           count    of values
  ///           scale    output for one SI unit of the channel
  EvenValues(const double* values, std::size_t count, double scale) : view_(values), count_(count), scale_(scale) {}
  EvenValues(std::vector<double> values, double scale)
      : count_(values.size()), scale_(scale), copy_(std::move(values)) {}

  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  /// Value of sample i [SI].
  double operator[](std::size_t i) const { return scale_ * data()[i]; }
  Iterator begin() const { return {data(), scale_}; }
  Iterator end() const { return {data() + count_, scale_}; }
  /// Only the first `count` of them from now on.
  void shorten(std::size_t count) { count_ = count; }

 private:
  const double* data() const { return copy_.empty() ? view_ : copy_.data(); }

  const double* view_ = nullptr;
  std::size_t count_ = 0;
  double scale_ = 1.0;
  std::vector<double> copy_;
};

/// Places that may always be filled: 2^24, of 128 MB; and places for each sample.
constexpr double always_filled = 16777216.0, filled_of_sample = 64.0;

/// Whether so many places [1] may be filled for `present` samples [1], one by one.
constexpr bool may_be_filled(double places, std::size_t present) {
  return places <= always_filled || places <= filled_of_sample * static_cast<double>(present);
}

/// Samples on an even grid.
struct EvenSamples {
  double first = 0.0;     ///< [s, channel's clock] stamp of the first one
  double step = 0.0;      ///< [s]
  std::size_t count = 0;  ///< present or missing
  EvenValues values = {};
};

/// The samples of a channel whose interval lies between two times, on the even grid that begins with the first of them.
///
/// Given     rate         [Hz] of the channel
///           begin, end   [s, channel's clock]
///           scale        output for one SI unit of the channel
/// Throws    Error::bad_data where by far most of the samples are missing; see may_be_filled
EvenSamples even_samples(const Channel& channel, double rate, double begin, double end, double scale);

}  // namespace tumble
