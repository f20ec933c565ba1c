#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/core/finding.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/reduce/even_values.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/error.hpp"

/// The test as it was carried out: each mark of a recording is a segment of its plan's schedule, in which the plan's
/// rig without errors says what was felt, and some samples of which are used.
namespace tumble {

/// The segment that one mark of a recording begins.
struct MarkedSegment {
  std::size_t recording = 0;  ///< index in Evidence::recordings
  std::size_t mark = 0;       ///< index in Recording::marks
  std::string label;
  int run = 1;
  double begin = 0.0;  ///< [s, recording's clock]
  double end = 0.0;    ///< [s, recording's clock] of the next mark; infinity for the last
  const Segment* planned =
      nullptr;                 ///< in the schedule of the recording's plan; null: that has no segment of this label
  std::size_t index = 0;       ///< of `planned` in the schedule
  std::size_t start = 0;       ///< counts how often the instrument was switched on, over all recordings
  std::size_t repetition = 0;  ///< how often the recordings before hold this run of the plan
};

/// Places the marks of all recordings in the schedules of their plans.
///
/// A mark is the begin of the segment of its label and run. A label that occurs several times in a run is taken in
/// order, also over several files of one power-up; where some of these segments were not recorded, the marks before and
/// after decide which one it is. A run that the schedule lacks repeats one that it states. A segment that was recorded
/// before belongs to another start: the power-up was repeated.
///
/// Returned  one list a recording, one element a mark. `planned` points into the evidence's plans.
std::vector<std::vector<MarkedSegment>> marked_segments(const Evidence& evidence);

/// One power-up of one plan and what its rig does then, without errors.
struct PowerUp {
  const Plan* plan = nullptr;
  std::size_t plan_number = 0;  ///< counts the different plans
  RigRun rig;
  Reference reference;         ///< without functions where the plan names no rig
  double step = 0.0;           ///< [s] between the points at which the rig is asked
  double offset = 0.0;         ///< [s] of its first segment in the schedule of the power-up it is part of
  std::vector<double> begins;  ///< [s] since power-on of each segment, and the end of the last
};

/// Given     segments   of one power-up
///           rate       [Hz] at which the rig is asked
PowerUp power_up_of(const Plan& plan, Schedule segments, double rate);

/// The power-ups that the schedule of a plan states, in its order. Given: rate [Hz] at which the rig is asked.
std::vector<PowerUp> power_ups_of(const Plan& plan, double rate);

/// When the rig has reached the motion of a segment [s since power-on].
double settled_at(const PowerUp& power_up, std::size_t segment);

/// Duration of one turn of the slowest axis that turns at a constant rate [s]; 0: no axis does.
double longest_turn(const Segment& segment);

/// The samples of one segment that are used.
struct Stretch {
  std::size_t power_up = 0;  ///< index in ConductedTest::power_ups
  std::size_t segment = 0;   ///< in the power-up
  std::string label;
  int run = 1;
  std::size_t start = 0;       ///< see MarkedSegment
  std::size_t repetition = 0;  ///< see MarkedSegment
  std::size_t recording = 0;   ///< index in Evidence::recordings; 0 where predicted
  double power_on = 0.0;       ///< [s, recording's clock]; 0 where predicted
  double begin = 0.0;          ///< [s, recording's clock] from which samples are used: the rig has settled
  double end = 0.0;            ///< [s, recording's clock] of the segment, or of the next mark
  double first = 0.0;          ///< [s since power-on] stamp of the first sample
  double step = 0.0;           ///< [s] between samples
  std::size_t samples = 0;     ///< present or missing
  EvenValues values = {};      ///< [SI of the output], NaN: missing; empty where predicted or where no role is read
  bool steady = false;         ///< what is felt stays the same over the samples

  double duration() const { return static_cast<double>(samples) * step; }  ///< [s]
};

/// The needs of a method.
struct StretchOptions {
  std::string role;         ///< the channel whose samples are used and whose clock the rig is asked by
  double scale = 1.0;       ///< output [SI] for one SI unit of the channel
  int oversampling = 1;     ///< points in each sample at which the rig is asked
  double settling = 0.0;    ///< [s] not used after the rig has settled in each segment
  bool needs_site = false;  ///< without the Earth's rate and gravity the reference is wrong
  /// Segments to skip without a finding; null: none.
  std::function<bool(const Segment&)> passed_over = nullptr;
  /// Segments that are used from their beginning, settled or not; null: none.
  std::function<bool(const Segment&)> unsettled = nullptr;
};

/// The test as carried out, or as it would be.
struct ConductedTest {
  std::vector<PowerUp> power_ups;
  std::vector<Stretch> stretches;
  std::size_t plans = 0;   ///< how many different ones there are
  std::size_t starts = 0;  ///< how often the instrument was switched on
  Findings findings;       ///< warnings for the segments that are not used or were not recorded
};

/// The stretches of all recordings, in the order of their marks. A recording that [[recording]] calls the file of one
/// segment has that segment as a power-up of its own.
///
/// Throws    Error::bad_input for plans without rig, schedule or site; Error::bad_data where a recording has no channel
///           of the role, no even clock, no marks, or where no segment has usable samples
ConductedTest stretches(const Evidence& evidence, const StretchOptions& options);

/// The stretches that the plan, and the plans that its recordings name, would give at their sampling rates.
///
/// Throws    Error::bad_input
ConductedTest stretches(const Plan& plan, const StretchOptions& options);

/// For each stretch, the index of the first stretch that has the same values in a prediction: the rig does the same
/// there at the same times since power-on, as in the power-ups that repeat one. A stretch with recorded samples has its
/// own index, because others may lack other samples.
std::vector<std::size_t> first_alike(const ConductedTest& test);

/// A warning: the segment is not used, and why.
Finding unused_segment(const std::string& label, int run, Phrase why);

/// That no recording has these segments of a run.
Finding segments_not_recorded(int run, const std::vector<std::string>& labels);

/// Throws    Error of this kind, with all findings, where a test has no stretch
void refuse_unused(const ConductedTest& test, Error::Kind kind);

/// Samples of a channel in a stretch of time.
struct SampleRange {
  std::size_t begin = 0, end = 0;  ///< indices, begin <= i < end

  std::size_t size() const { return end - begin; }
};

/// Given     begin, end   [s, channel's clock], stamps begin <= t < end; either may be infinite
SampleRange samples_between(const Channel& channel, double begin, double end);

}  // namespace tumble
