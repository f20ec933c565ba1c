#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>

#include "tumble/departures/departure.hpp"
#include "tumble/models/model.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Bit by bit, so that missing samples are alike.
bool same_samples(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/// Whether the channel has the samples of the simulation, perhaps with something added.
bool comes_from(const Channel& channel, const Recording& simulated) {
  const Channel* made = find_channel(simulated, channel.name);
  return made != nullptr && made->values.size() == channel.values.size() && channel.timeline.uniform() &&
         channel.timeline.start == made->timeline.start && channel.timeline.rate == made->timeline.rate;
}

/// Whether the recording is that of the simulation: all channels have its clock, and one its very samples.
bool comes_from(const Recording& recording, const Recording& simulated) {
  const auto alike = [&](const Channel& channel) {
    return comes_from(channel, simulated) &&
           same_samples(channel.values, find_channel(simulated, channel.name)->values);
  };
  return std::ranges::any_of(recording.channels, alike) && recording.marks.size() == simulated.marks.size();
}

bool can_be_simulated(const Plan& plan) {
  return !plan.instrument_model.empty() && !plan.rig_kind.empty() && plan.sample_rate > 0.0 && !plan.schedule.empty() &&
         !plan.truth.texts().empty();
}

/// What the test makes of a sample of the simulation: its electronics, as a line from one sample to the next greater one.
class Electronics {
 public:
  Electronics(const Channel& simulated, const Channel& channel) {
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      if (!std::isnan(channel.values[i])) shown_.emplace(simulated.values[i], channel.values[i]);
  }
  double operator()(double sample) const {
    auto above = shown_.upper_bound(sample);
    if (above == shown_.end()) --above;
    if (above == shown_.begin()) ++above;
    const auto below = std::prev(above);
    return below->second + (sample - below->first) / (above->first - below->first) * (above->second - below->second);
  }
  bool known() const { return shown_.size() > 1; }

 private:
  std::map<double, double> shown_;
};

/// The samples of a channel where the plan was carried out in another way. What the test added to those of the
/// simulation is added again; a channel in another unit passes through the electronics of the test again.
void carry_over(const Channel& before, const Channel& after, Channel& channel) {
  if (!(channel.unit.dimension() == before.unit.dimension()) && before.values.size() == after.values.size()) {
    const Electronics electronics(before, channel);
    for (std::size_t i = 0; electronics.known() && i < channel.values.size(); ++i)
      if (!std::isnan(channel.values[i])) channel.values[i] = electronics(after.values[i]);
    return;
  }
  if (same_samples(channel.values, before.values)) {
    channel.values = after.values;
    return;
  }
  if (before.values.size() != after.values.size())
    throw Error(Error::Kind::bad_input,
                say("channel '{}' has samples that do not follow from the plan, and the departure changes their number",
                    Name{channel.name}));
  for (std::size_t i = 0; i < channel.values.size(); ++i) channel.values[i] += after.values[i] - before.values[i];
}

/// From nothing at the beginning to all of the change at the end.
void grow_evenly(const Recording& before, Recording& after) {
  for (Channel& channel : after.channels) {
    const Channel& sound = *find_channel(before, channel.name);
    if (sound.values.size() != channel.values.size())
      throw Error(Error::Kind::internal, say("a departure that drifts changes the number of samples"));
    const auto last = static_cast<double>(std::max<std::size_t>(channel.values.size(), 2) - 1);
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      channel.values[i] = std::lerp(sound.values[i], channel.values[i], static_cast<double>(i) / last);
  }
}

/// Makes the recording of the test again, from the plan that is carried out now.
void simulate_again(bool drifts, SimulatedTest& test) {
  Recording again = simulate(test.carried_out, test.seed, {});
  if (drifts) grow_evenly(*test.simulated, again);
  Recording& recording = test.evidence.recordings.front();
  for (Channel& channel : recording.channels) {
    const Channel* before = find_channel(*test.simulated, channel.name);
    const Channel* after = find_channel(again, channel.name);
    if (before == nullptr || after == nullptr)
      throw Error(Error::Kind::bad_input,
                  say("channel '{}' of the test is not one that the simulation makes", Name{channel.name}));
    carry_over(*before, *after, channel);
  }
  recording.marks = again.marks;
  test.simulated = std::make_shared<const Recording>(std::move(again));
}

}  // namespace

SimulatedTest simulated_test(const Plan& plan, std::uint64_t seed) {
  const auto simulated = std::make_shared<const Recording>(simulate(plan, seed, {}));
  SimulatedTest test{.evidence = {plan, {*simulated}, {}}, .carried_out = plan, .seed = seed, .simulated = simulated};
  const Model& model = find_model(plan.instrument_model);
  for (const Output& output : model.outputs(plan.truth)) {
    const auto coefficients = coefficients_of(model, output, plan.truth);
    for (std::size_t k = 0; k < output.terms.size(); ++k)
      test.truth.emplace_back(output.terms[k].name, coefficients[k]);
  }
  return test;
}

SimulatedTest simulated_test(Evidence evidence, std::vector<std::pair<std::string, double>> truth, std::uint64_t seed) {
  SimulatedTest test{.evidence = std::move(evidence), .truth = std::move(truth), .seed = seed};
  test.carried_out = test.evidence.plan;
  if (test.evidence.recordings.size() != 1 || !can_be_simulated(test.carried_out)) return test;
  Recording simulated = simulate(test.carried_out, seed, {});
  if (comes_from(test.evidence.recordings.front(), simulated))
    test.simulated = std::make_shared<const Recording>(std::move(simulated));
  return test;
}

SimulatedTest with_departure(const SimulatedTest& test, const Departure& departure, const std::string& target,
                             double size, std::uint64_t seed) {
  SimulatedTest out = test;
  const Happening what{target, size, RandomStream(seed).split("departure").split(departure.name)};
  if (departure.carry_out != nullptr) {
    if (test.simulated == nullptr)
      throw Error(Error::Kind::bad_input,
                  say("'{}' changes how a plan is carried out, and the recordings of this test were not made from one",
                      Name{departure.name}));
    departure.carry_out(out.carried_out, what);
    simulate_again(departure.drifts, out);
  }
  if (departure.record != nullptr) departure.record(out.evidence.plan, out.evidence.recordings, what);
  return out;
}

}  // namespace tumble
