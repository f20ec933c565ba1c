#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "tumble/clocks/clock.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/finding.hpp"
#include "tumble/reduce/rig_effects.hpp"

namespace tumble::frequency_response {

/// How the numbers of the two channels become quantities of one kind, and the effect of sampling on them.
struct Scaling {
  double output = 1.0;            ///< output [SI of the reference, or its derivative] for one SI unit of the channel
  double output_window = 0.0;     ///< [s] over which a sample of the output is the mean, from its stamp on
  double reference_window = 0.0;  ///< [s]
  double output_shift = 0.0;      ///< [s] from the stamp to the instant of the sample, with the clock offset
  double reference_shift = 0.0;   ///< [s]
  bool differentiate = false;     ///< the reference is an angle, the output a rate
  bool relative = false;          ///< of different kinds: gains are relative to the lowest frequency
};

/// A channel with the rate [Hz] of its clock and its gaps, so that lost samples change neither rates nor phases.
struct Signal {
  const Channel* channel = nullptr;
  double rate = 0.0;
  std::vector<Clock::Gap> gaps;
  /// [s] of the first sample on the even clock behind stamps that are rounded, or scatter by less than half a sample; none:
  /// the stamps say when samples were taken.
  std::optional<double> start = {};

  double time(std::size_t sample) const {  ///< [s]
    return start ? *start + static_cast<double>(sample) / rate : channel->time(sample);
  }
};

/// Part of a recording in which the excitation may be one tone or one sweep.
struct Part {
  std::string label;
  Signal output, reference;
  double begin = 0.0, end = 0.0;  ///< [s]
  std::optional<Motion> motion;   ///< sine or sweep that the plan commands there
};

struct Data {
  std::vector<Part> parts;
  Scaling scaling;
  std::string output_name;
  Unit output_unit, reference_unit;
  bool from_rig = false;     ///< no reference was recorded: it is the motion commanded to the plan's rig
  std::deque<Channel> made;  ///< references from the rig
  Findings findings;
};

/// Channels, parts and scaling. Where the reference comes from the plan's rig, it does so with `error` at one standard
/// deviation in all segments; null: without errors.
Data data_of(const Evidence& evidence, const PlanError* error);

/// Errors of the plan's rig with a standard deviation above zero; none without a rig.
std::vector<PlanError> errors_of_rig(const Evidence& evidence);

/// Samples of a channel in [begin, end), stamps moved by `shift` [s]; lost samples are there, as NaN.
struct Samples {
  std::vector<double> time, value;
  double rate = 0.0;
  std::size_t missing = 0;
};
/// Given: begin, end, shift [s].
Samples samples_of(const Signal& signal, double begin, double end, double shift);

}  // namespace tumble::frequency_response
