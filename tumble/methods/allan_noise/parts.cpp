#include <fmt/format.h>

#include <utility>

#include "tumble/math/state.hpp"
#include "tumble/methods/allan_noise/stream.hpp"
#include "tumble/methods/noise_parts.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

using allan_noise::ChannelState;
using allan_noise::EvenStream;

namespace {

void require_allan_noise(const Plan& plan) {
  if (plan.method != "allan_noise")
    throw Error(Error::Kind::unsupported,
                say("method '{}' needs a recording as a whole; the method that works through parts of it is "
                    "allan_noise",
                    plan.method));
  allan_noise::check_settings(plan.settings);
  allan_noise::refuse_unstreamable(plan.settings);
}

using Clocks = std::vector<std::pair<std::size_t, EvenStream>>;  // by number of the channel in a block

Clocks clocks_of(const Recording& block, const Plan& plan) {
  Clocks clocks;
  for (const auto& [stretch, index] : allan_noise::channels_of_block(block, plan))
    clocks.emplace_back(index, EvenStream(stretch.label, plan.settings));
  return clocks;
}

}  // namespace

struct NoiseExtent::Work {
  Plan plan;
  Clocks clocks;
  std::vector<ChannelExtent> channels;
  std::vector<double> values;
};

NoiseExtent::NoiseExtent(const Plan& plan) : work_(std::make_unique<Work>(Work{plan, {}, {}, {}})) {
  require_allan_noise(plan);
}
NoiseExtent::~NoiseExtent() = default;

void NoiseExtent::push(const Recording& block) {
  if (work_->clocks.empty()) {
    work_->clocks = clocks_of(block, work_->plan);
    for (const auto& [stretch, index] : allan_noise::channels_of_block(block, work_->plan))
      work_->channels.push_back({stretch.label});
  }
  for (std::size_t i = 0; i < work_->clocks.size(); ++i) {
    work_->values.clear();
    work_->clocks[i].second.take(block.channels[work_->clocks[i].first], work_->values);
    work_->channels[i].samples += work_->values.size();
  }
}

std::vector<ChannelExtent> NoiseExtent::channels() const {
  auto channels = work_->channels;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto clock = work_->clocks[i].second.clocked();
    channels[i].rate = clock.rate;
    channels[i].begin = clock.begin;
    channels[i].end = clock.end;
  }
  return channels;
}

struct NoisePart::Work {
  Plan plan;
  std::vector<PlaceInRecord> places;
  Clocks clocks;
  std::vector<ChannelState> channels;
  std::vector<double> values;

  void open(const Recording& block) {
    const auto found = allan_noise::channels_of_block(block, plan);
    if (found.size() != places.size())
      throw Error(Error::Kind::bad_data, say("{} channels were expected as in the other parts, and {} are there",
                                             places.size(), found.size()));
    clocks = clocks_of(block, plan);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const PlaceInRecord& place = places[i];
      ChannelState& state = channels.emplace_back(found[i].first, plan.settings, place.start, place.total);
      push(state, std::vector<double>(place.lost_before, std::nan("")));
    }
  }

  static void push(ChannelState& state, std::span<const double> values) {
    state.push_to_allan(values);
    state.push_to_bands(values);
  }
};

NoisePart::NoisePart(const Plan& plan, std::vector<PlaceInRecord> places)
    : work_(std::make_unique<Work>(Work{plan, std::move(places), {}, {}, {}})) {
  require_allan_noise(plan);
}
NoisePart::NoisePart(std::unique_ptr<Work> work) : work_(std::move(work)) {}
NoisePart::NoisePart(NoisePart&&) noexcept = default;
NoisePart& NoisePart::operator=(NoisePart&&) noexcept = default;
NoisePart::~NoisePart() = default;

void NoisePart::push(const Recording& block) {
  if (work_->channels.empty()) work_->open(block);
  for (std::size_t i = 0; i < work_->clocks.size(); ++i) {
    work_->values.clear();
    work_->clocks[i].second.take(block.channels[work_->clocks[i].first], work_->values);
    Work::push(work_->channels[i], work_->values);
  }
}

void NoisePart::close() {
  for (std::size_t i = 0; i < work_->clocks.size(); ++i) {
    work_->channels[i].clock = work_->clocks[i].second.clocked();
    work_->channels[i].close();
  }
}

void NoisePart::append(const NoisePart& next) {
  if (next.work_->channels.size() != work_->channels.size())
    throw Error(Error::Kind::bad_input, "the parts have different numbers of channels");
  for (std::size_t i = 0; i < work_->channels.size(); ++i) work_->channels[i].append(next.work_->channels[i]);
}

Estimate NoisePart::estimate(const Plan& plan) const {
  std::vector<allan_noise::ChannelNoise> results;
  for (const ChannelState& state : work_->channels) results.push_back(state.noise(plan.settings));
  return allan_noise::described_stream(results, plan);
}

std::string NoisePart::bytes() const {
  StateWriter state;
  state(work_->channels);
  return state.take();
}

NoisePart NoisePart::from_bytes(std::string_view bytes) {
  auto work = std::make_unique<Work>();
  StateReader state(bytes);
  state(work->channels);
  if (!state.ended()) throw Error(Error::Kind::bad_file, "the state of a part of a record is too long");
  return NoisePart(std::move(work));
}

}  // namespace tumble
