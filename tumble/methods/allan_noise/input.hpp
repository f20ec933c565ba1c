#pragma once

#include <string>
#include <vector>

#include "tumble/core/settings.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/reduce/even_signal.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::allan_noise {

/// Problems of `data`, `pulse` and `taus` beside each other; empty: they fit.
Problems input_problems(const Settings& settings);

/// The channels that `data` may be in.
ChannelsWanted channels_of_data(const Settings& settings);

/// Quantity of the deviation of a channel: angular rate or specific force; `other`: a fractional frequency.
QuantityKind kind_of_rate(const Channel& channel, const Settings& settings);

/// The samples of a stretch as a rate [u] on an even clock, from what `data` says they are, T the sampling interval:
///   rate, frequency   y_n = x_n            increment  y_n = x_n/T
///   angle, phase      y_n = (x_{n+1} - x_n)/T          count  y_n = pulse x_n/T
/// NaN where a sample is missing, and for an increment after it: it may be that of one interval or of all. Without the
/// beginning that `from` excludes. Throws as even_signal; Error::bad_data where the record is too short to have a rate.
EvenSignal rate_signal(const ChannelRun& stretch, const Settings& settings);

/// A signal without what `from` excludes at its begin. Throws Error::bad_data where nothing remains.
EvenSignal from_start(EvenSignal signal, const Settings& settings);

/// Averaging times, confidence and treatment of bias and mean rate that the settings ask for.
AllanOptions curve_options_of(const Settings& settings, const EvenSignal& signal);

/// Averaging factors [samples] that `taus` asks for; empty: points_per_decade of them. Throws Error::bad_data for an
/// averaging time that is shorter than the sampling interval, or longer than `samples` allow.
std::vector<std::size_t> asked_factors(const Settings& settings, double rate, std::size_t samples);

}  // namespace tumble::allan_noise
