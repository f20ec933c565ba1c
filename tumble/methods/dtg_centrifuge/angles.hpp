#pragma once

#include <vector>

#include "tumble/methods/dtg_centrifuge/data.hpp"

/// Where arm and table stand in the middle of each sample.
namespace tumble::dtg_centrifuge {

class Angles {
 public:
  /// From the encoders. `in_middle`: a reading is that in the middle of the interval which begins at its stamp.
  /// Given: begin, end [s].
  Angles(const Channels& channels, bool in_middle, double begin, double end);
  /// Even turning at these rates [rad/s]; the angles are zero at `centre` [s].
  Angles(double arm_rate, double table_rate, double centre);

  double arm_rate() const { return arm_.rate; }      ///< [rad/s] mean from begin to end
  double table_rate() const { return table_.rate; }  ///< [rad/s]
  double unsteady() const;  ///< [1] greatest relative departure of the rate over a sixteenth from the mean

  /// Angles [rad] in the middle of `count` samples of `channel` from sample `first` on, which are `step` [s] long.
  /// Points into the encoders' own samples where their clock is that of the channel, else into `work`.
  void at(const Channel& channel, double step, std::size_t first, std::size_t count, std::vector<double>& work,
          const double*& arm, const double*& table) const;

 private:
  struct Axis {
    const Channel* channel = nullptr;
    std::vector<double> unwound;  ///< readings that start at zero every turn, without these jumps, from `first` on
    std::size_t first = 0;
    double offset = 0.0;  ///< [s] from the stamp to the instant
    double rate = 0.0, unsteady = 0.0;
    double value(std::size_t i) const { return unwound.empty() ? channel->values[i] : unwound[i - first]; }
  };
  static Axis axis_of(const Channel& channel, double offset, double begin, double end);
  const double* of(const Axis& axis, const Channel& channel, double middle, std::size_t first, std::size_t count,
                   double* work) const;

  Axis arm_, table_;
  double centre_ = 0.0;
};

}  // namespace tumble::dtg_centrifuge
