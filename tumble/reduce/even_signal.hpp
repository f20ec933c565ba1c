#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/finding.hpp"
#include "tumble/math/extremes.hpp"

namespace tumble {

/// [1] by which the rate that a plan or an option states must differ from the rate of the stamps to be a finding.
/// Chosen: quartz crystals and dividers are nearer by far, and 1 % of the rate is 0.5 % of an angle random walk.
constexpr double rate_differs = 0.01;

/// One power-up of one channel.
struct ChannelRun {
  const Channel* channel = nullptr;
  std::string label;  ///< the channel's name, with ".run2" and so on where the name occurs again
  std::size_t begin = 0, end = 0;
  std::size_t recording = 0;
  double run = 0.0;  ///< [s] its begin, -inf of a recording without marks
};

/// Channels that a method can work on, and its words for them: "an angular rate or a specific force, as in deg/h".
struct ChannelsWanted {
  std::function<bool(const Channel&)> accepts;
  std::string what;
};

/// The wanted channels (or the one with role `signal`) of every recording, one stretch a run.
/// Throws Error::bad_data that lists what the recordings hold, if no channel is of a wanted kind, or that the signal is
/// not wanted.
std::vector<ChannelRun> channel_runs(const Evidence& evidence, const ChannelsWanted& wanted);
/// The angular-rate and specific-force channels.
std::vector<ChannelRun> channel_runs(const Evidence& evidence);

/// Samples [begin, end) of a record.
struct RecordPart {
  std::size_t begin = 0, end = 0;
};

/// Evenly spaced samples of a stretch. NaN: missing.
struct EvenSignal {
  std::span<const double> values;  ///< of the channel itself, or of `made`
  std::vector<double> made;
  Extremes extremes;   ///< of the values
  double rate = 0.0;   ///< [Hz]
  double begin = 0.0;  ///< [s] time of the first sample
  Findings findings;
};

/// Brings a stretch onto an even clock.
///
/// Given     rate    [Hz] of the samples, independent of the stamps; 0: as the channel states it
///           timing  "even": evenly spaced at the mean rate; "stamps": samples averaged onto an even grid by their
///                   stamps; "auto": even if the clock is even beneath late stamps, with lost samples put in as NaN,
///                   else by stamps
/// Throws    Error::bad_data for a clock that runs backwards (time named) or an infinite sample
EvenSignal even_signal(const ChannelRun& stretch, double rate, const std::string& timing);

/// Extremes of the samples begin <= i < end [SI]. Throws Error::bad_data that names the first infinite sample.
Extremes finite_extremes(const Channel& channel, std::size_t begin, std::size_t end, const std::string& label);

/// Reason why a noise analysis is not possible (too short, constant, NaN); empty for a usable signal.
/// Given: rate [Hz].
Sentence unusable(const Extremes& extremes, std::size_t samples, double rate);
Sentence unusable(const EvenSignal& signal);

/// Scatter of a block of samples, the first of which is number `first` of the record.
struct Scatter {
  double count = 0.0, mean = 0.0, sd = 0.0;
  std::size_t first = 0;
};
/// Given: values [u]; NaN: missing.
Scatter scatter_of(std::span<const double> values, std::size_t first);

/// Within 400 equal blocks, of 20 samples and more; samples that remain at the end are not used.
struct BlockScatter {
  std::size_t size = 0;  ///< of a block [samples]
  std::vector<Scatter> blocks;
};
/// Given: values [u]; NaN: missing.
BlockScatter block_scatter(std::span<const double> values);

/// Parts of the record that are not like the rest: motion, outliers, steps.
Findings disturbances(const EvenSignal& signal, const std::string& label);
/// Disturbances from the scatter within blocks of `size` samples of a record that begins at `begin` [s].
Findings disturbances(const std::vector<Scatter>& blocks, std::size_t size, double rate, double begin,
                      const std::string& label);

}  // namespace tumble
