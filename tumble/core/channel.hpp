#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/units/unit.hpp"

namespace tumble {

/// Kind of quantity that a channel measures; it follows from the unit where the file does not say.
enum class QuantityKind {
  angular_rate,
  angle,  ///< or angle increment
  specific_force,
  velocity,  ///< or velocity increment
  count,
  temperature,
  time,
  other
};

std::string_view name(QuantityKind kind);
QuantityKind kind_of(const Unit& unit);

/// When the samples were taken: evenly (start and rate), or at given stamps shared by the channels of one file.
struct Timeline {
  double start = 0.0;                                 ///< [s] of the first sample
  double rate = 0.0;                                  ///< [Hz]; 0: see stamps
  std::shared_ptr<const std::vector<double>> stamps;  ///< [s], one a sample; null when evenly sampled

  bool uniform() const { return stamps == nullptr; }
  /// Time of a sample [s].
  double time(std::size_t sample) const {
    return uniform() ? start + static_cast<double>(sample) / rate : (*stamps)[sample];
  }
};

/// One measured signal. Values are in SI; `unit` is what the file or plan wrote and what people are shown.
/// A missing sample is NaN.
struct Channel {
  std::string name;
  QuantityKind kind = QuantityKind::other;
  Unit unit;
  Timeline timeline;
  std::vector<double> values;

  double time(std::size_t sample) const { return timeline.time(sample); }  ///< [s]
};

/// Mean sampling rate [Hz]; 0 for fewer than two samples.
double mean_rate(const Channel& channel);
/// Last stamp minus first [s].
double span(const Channel& channel);
/// Index of the first sample at or after `time` [s]; stamps must not run backwards.
std::size_t index_at(const Channel& channel, double time);

}  // namespace tumble
