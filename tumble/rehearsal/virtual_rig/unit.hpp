#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tumble/rehearsal/virtual_rig.hpp"
#include "tumble/rehearsal/virtual_rig/course.hpp"
#include "tumble/sim/instrument_run.hpp"

namespace tumble::virtual_rig {

/// The instruments and the rig's sensors from one switching-on to the next switching-off. Samples are made in the
/// portions of simulate(), in advance; a portion is made again, from the state at its begin, if the rig turns out to
/// move in another way.
class Unit {
 public:
  /// Given  run     number, begin [s of the station] and planned samples of the power-up
  ///        offset  [s] its begin within the course
  Unit(std::shared_ptr<const Plan> plan, const RandomStream& random, const PlannedRun& run, int power_up,
       double offset);

  /// In [s].
  double begin() const { return begin_; }
  int power_up() const { return power_up_; }
  std::size_t given() const { return given_; }
  /// Switched off at this time [s of the station].
  void end(double time);
  bool ended() const { return total_.has_value(); }
  bool exhausted() const { return total_ && given_ >= *total_; }

  /// Number of samples that are known at this time [s of the station].
  std::size_t known(double time, SampleTiming timing) const;
  /// The next samples, up to number `until`.
  VirtualSamples take(Course& course, std::size_t until);

 private:
  struct Portion {
    std::size_t first = 0, size = 0, version = 0;
    std::vector<std::vector<double>> values = {};
    bool covers(std::size_t sample) const { return size > 0 && sample >= first && sample < first + size; }
  };

  void make_outputs(Course& course);
  void make_sensors(Course& course);
  std::size_t size_from(std::size_t first, std::size_t portion) const;
  const Reference& reference(Course& course, std::size_t until);

  std::shared_ptr<const Plan> plan_;
  double begin_, offset_, rate_, steps_per_sample_;
  int power_up_;
  InstrumentRun before_, after_;  ///< at the begin and at the end of the portion
  Portion outputs_, sensors_;
  Reference shifted_;
  std::vector<Channel> channels_;  ///< without values
  std::size_t given_ = 0;
  std::optional<std::size_t> total_;
};

}  // namespace tumble::virtual_rig
