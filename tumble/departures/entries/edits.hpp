#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/departures/departure.hpp"
#include "tumble/models/model.hpp"

/// Functions that the entries share: which channels there are, and how samples and stamps are changed.
namespace tumble::entries {

/// The whole test, where it has samples.
std::vector<std::string> whole_test(const Plan& plan, const Recordings& recordings);

/// Names of the outputs of the instruments. Without a model in the plan: rates, forces and counts, except a channel that
/// is called a reference.
std::vector<std::string> all_outputs(const Plan& plan, const Recordings& recordings);
/// The first output of each kind of quantity: what happens to one of a triad may happen to the others alike. Those that the
/// plan names for the method, and the others, count as kinds of their own.
std::vector<std::string> outputs(const Plan& plan, const Recordings& recordings);
/// Channels that are no output: encoders, thermometers, reference sensors.
std::vector<std::string> references(const Plan& plan, const Recordings& recordings);
/// References that are an angle.
std::vector<std::string> encoders(const Plan& plan, const Recordings& recordings);
/// References that are a temperature.
std::vector<std::string> thermometers(const Plan& plan, const Recordings& recordings);
/// References that are neither: what an output may be compared with.
std::vector<std::string> reference_sensors(const Plan& plan, const Recordings& recordings);
/// Whether a channel holds counts.
bool is_count(const Recordings& recordings, const std::string& name);
/// The first of the names, if there is one.
std::vector<std::string> first_of(std::vector<std::string> names);

/// Calls `edit` with the channel of that name in each recording that has it.
void edit_channel(Recordings& recordings, const std::string& name, const std::function<void(Channel&)>& edit);
/// Calls `edit` with each channel, whose name is among `names`.
void edit_channels(Recordings& recordings, const std::vector<std::string>& names,
                   const std::function<void(Channel&)>& edit);
/// Replaces each sample [SI of the channel], but missing ones.
void edit_values(Recordings& recordings, const std::string& name, const std::function<double(double)>& edit);
/// Values as a channel shows them, one after another: a counter has whole steps of so many pulses, and passes the rest on to the
/// next window. Other channels are shown as they are.
class Counted {
 public:
  explicit Counted(const Channel& channel, double step = 1.0);
  double operator()(double value);  ///< [SI of the channel]

 private:
  double step_, rest_ = 0.0;
};
/// As edit_values [SI of the channel], where the instrument or its electronics change: counts stay whole, the rest is passed on
/// to the next window.
void edit_measured(Recordings& recordings, const std::string& name, const std::function<double(double)>& edit);
/// Counts every n-th pulse, n [1]: a divider before the counter of a channel.
void divide_counts(Recordings& recordings, const std::string& name, double n);
/// Adds to each sample of the channel the value [SI] that the function gives for its fraction of the record (0 to 1); counts stay
/// whole.
void add_along(Recordings& recordings, const std::string& name, const std::function<double(double)>& added);

/// Response of electronics to the samples of a channel, whose interval is `step` [s]; a missing sample stays missing and counts as the one before.
void pass_through(Recordings& recordings, const std::string& name,
                  const std::function<Response(double step)>& response);

/// Replaces the stamps: `stamp` gives a new one [s] from a stamp [s] and the number of its sample.
void restamp(Channel& channel, const std::function<double(double time, std::size_t sample)>& stamp);

/// Removes the samples, with their stamps, of which `lost` holds.
void remove_samples(Channel& channel, const std::function<bool(std::size_t sample)>& lost);

/// Mean interval between samples [s] of the channel of that name, of the first channel for "".
double sample_interval(const Recordings& recordings, const std::string& name);

/// A plain crystal oscillator is off by this much [1] between its calibrations; the check stated_rate warns of stamps beyond it.
inline constexpr double crystal = 100e-6;

/// Half an interval between samples [s]: what is left open where nobody says whether a stamp is the beginning or the middle of
/// its sample.
double half_a_sample(const Plan& plan, const Recordings& recordings, const std::string& name);
/// The zero of an axis or of its encoder is known this well [rad] by the budget.
double covered_index(const Plan& plan, const Recordings& recordings, const std::string& name);

/// Standard deviation of the noise of a channel [SI], from the median change between neighbours; the least change
/// where most neighbours are alike.
double noise_of(const Recordings& recordings, const std::string& name);

/// Bias [SI] of an output that a budget covers: the change from power-up to power-up or the bias instability that
/// [truth] states, the greater of them; else a tenth of the noise of a sample, which a mean of 100 samples has.
double covered_bias(const Plan& plan, const Recordings& recordings, const std::string& name);

/// A number of the rig's options [SI]; `otherwise` where the rig has no such option or no value of it.
double rig_number(const Plan& plan, const char* option, double otherwise);

/// Adds an amount [SI] to a number of the rig's options, where it has it.
void add_to_rig(Plan& plan, const char* option, double amount);
/// Multiplies a number of the rig's options by a factor [1], where it has it.
void scale_in_rig(Plan& plan, const char* option, double factor);
/// Whether the rig has one of these options, with a value.
bool rig_has(const Plan& plan, std::initializer_list<const char*> options);

}  // namespace tumble::entries
