#include "tumble/reduce/even_signal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tumble/clocks/clock.hpp"
#include "tumble/language/say.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Severity = Finding::Severity;

constexpr std::size_t least_block = 20, most_blocks = 400;  ///< samples of a block whose scatter is compared; blocks
constexpr std::size_t fewest_blocks = 10;                   ///< of whose scatters the usual one is the median

bool is_inertial(const Channel& channel) {
  return channel.kind == QuantityKind::angular_rate || channel.kind == QuantityKind::specific_force;
}

std::vector<const Channel*> chosen(const Evidence& evidence, const Recording& recording, const ChannelsWanted& wanted) {
  if (const Channel* signal = channel_for(evidence, recording, "signal"); signal != nullptr) return {signal};
  std::vector<const Channel*> channels;
  for (const auto& channel : recording.channels)
    if (wanted.accepts(channel)) channels.push_back(&channel);
  return channels;
}

std::string described(const std::vector<Recording>& recordings) {
  std::string text;
  for (const auto& recording : recordings)
    for (const auto& channel : recording.channels)
      text += fmt::format("{}{} [{}]", text.empty() ? "" : ", ", channel.name, channel.unit.text());
  return text.empty() ? "no channel" : text;
}

std::vector<double> slice(const ChannelRun& stretch) {
  const auto& values = stretch.channel->values;
  return {values.begin() + static_cast<std::ptrdiff_t>(stretch.begin),
          values.begin() + static_cast<std::ptrdiff_t>(stretch.end)};
}

/// The stretch as a channel of its own, for its clock alone.
Channel times_of(const ChannelRun& stretch) {
  Channel channel;
  channel.name = stretch.label;
  channel.timeline.rate = stretch.channel->timeline.rate;
  const auto& stamps = *stretch.channel->timeline.stamps;
  channel.timeline.stamps =
      std::make_shared<const std::vector<double>>(stamps.begin() + static_cast<std::ptrdiff_t>(stretch.begin),
                                                  stamps.begin() + static_cast<std::ptrdiff_t>(stretch.end));
  channel.values = slice(stretch);
  return channel;
}

/// Lost samples put in as NaN, so that the count of samples is the clock again.
std::vector<double> with_gaps(const std::vector<double>& values, const std::vector<Clock::Gap>& gaps) {
  std::vector<double> filled;
  std::size_t from = 0;
  for (const auto& gap : gaps) {
    filled.insert(filled.end(), values.begin() + static_cast<std::ptrdiff_t>(from),
                  values.begin() + static_cast<std::ptrdiff_t>(gap.after + 1));
    filled.insert(filled.end(), gap.lost, std::nan(""));
    from = gap.after + 1;
  }
  filled.insert(filled.end(), values.begin() + static_cast<std::ptrdiff_t>(from), values.end());
  return filled;
}

/// Mean of the samples whose stamps lie within half an interval of each point of the grid; NaN where none does.
std::vector<double> on_grid(const std::vector<double>& stamps, const std::vector<double>& values, double rate) {
  const double last = std::floor((stamps.back() - stamps.front()) * rate + 0.5);
  std::vector<double> sum(static_cast<std::size_t>(last) + 1, 0.0);
  std::vector<unsigned> count(sum.size(), 0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double at = std::floor((stamps[i] - stamps.front()) * rate + 0.5);
    if (std::isnan(values[i]) || at > last) continue;
    sum[static_cast<std::size_t>(at)] += values[i];
    ++count[static_cast<std::size_t>(at)];
  }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = count[i] == 0 ? std::nan("") : sum[i] / count[i];
  return sum;
}

/// Lost samples are put in one by one: a week between two short pieces takes more memory than all else.
void refuse_pieces_far_apart(const std::vector<double>& stamps, double rate) {
  const double length = stamps.back() - stamps.front();
  if (may_be_filled(length * rate, stamps.size())) return;
  std::size_t longest = 1;
  for (std::size_t i = 1; i < stamps.size(); ++i)
    if (stamps[i] - stamps[i - 1] > stamps[longest] - stamps[longest - 1]) longest = i;
  throw Error(Error::Kind::bad_data,
              say("{} samples in {}, with a pause of {} at {}: the pieces are too far apart to be one "
                  "record. Put each piece into a file of its own, or mark each as a run of its own",
                  stamps.size(), Name{say_seconds(length)}, Name{say_seconds(stamps[longest] - stamps[longest - 1])},
                  Name{say_instant(stamps[longest - 1])}));
}

void by_clock(const ChannelRun& stretch, const std::string& timing, EvenSignal& signal) {
  const Channel times = times_of(stretch);
  const auto& stamps = *times.timeline.stamps;
  const Clock clock = clock_of(times);
  if (clock.backward > 0)
    throw Error(Error::Kind::bad_data,
                say("the clock runs backwards at {} ({} in all): mend the stamps, or say rate=... to take "
                    "the samples as evenly spaced",
                    Name{say_instant(stamps[clock.first_backward])}, said_count(clock.backward, "step")));
  signal.rate = clock.rate > 0.0 ? clock.rate : mean_rate(times);
  if (!(signal.rate > 0.0) || !std::isfinite(signal.rate)) return;
  const FindingValue rms{"rms", clock.jitter_rms, "s"};
  const auto say = [&](std::string code, std::vector<FindingValue> values, Occurrences occurrences = {}) {
    signal.findings.push_back(
        {Severity::info, std::move(code), std::move(values), stretch.label, std::move(occurrences)});
  };
  if (timing == "even" || (timing == "auto" && clock.even)) {
    if (timing == "even") signal.rate = mean_rate(times);
    if (clock.worst * signal.rate > 0.5)
      say("uneven_stamps_taken_as_even", {{"rate", signal.rate, "Hz"}, rms, {"greatest", clock.worst, "s"}});
    return;
  }
  refuse_pieces_far_apart(stamps, signal.rate);
  if (timing == "auto" && !clock.gaps.empty()) {
    std::size_t lost = 0;
    for (const auto& gap : clock.gaps) lost += gap.lost;
    const auto& longest = *std::ranges::max_element(clock.gaps, {}, &Clock::Gap::lost);
    signal.made = with_gaps(slice(stretch), clock.gaps);
    say("gaps_kept_as_missing", {{"lost", lost}}, {clock.gaps.size(), clock.gaps.front().begin, longest.begin});
  } else {
    signal.made = on_grid(stamps, slice(stretch), signal.rate);
    say("averaged_onto_grid", {{"rate", signal.rate, "Hz"}, rms});
  }
}

}  // namespace

std::vector<ChannelRun> channel_runs(const Evidence& evidence) {
  return channel_runs(evidence, {is_inertial, "an angular rate or a specific force, as in deg/h or m/s^2"});
}

std::vector<ChannelRun> channel_runs(const Evidence& evidence, const ChannelsWanted& wanted) {
  std::vector<ChannelRun> all;
  std::map<std::string, int> runs;
  for (const auto& run : runs_of(evidence.recordings)) {
    const Recording& recording = evidence.recordings[run.recording];
    for (const Channel* channel : chosen(evidence, recording, wanted)) {
      if (!wanted.accepts(*channel))
        throw Error(Error::Kind::bad_data, say("{} is in {}: the method needs {}", Name{channel->name},
                                               Name{channel->unit.text()}, Sentence(wanted.what.c_str())));
      const SampleRange range = samples_between(*channel, run.begin, run.end);
      ChannelRun stretch{channel, channel->name, range.begin, range.end, run.recording, run.begin};
      const int number = ++runs[channel->name];
      if (number > 1) stretch.label += fmt::format(".run{}", number);
      all.push_back(stretch);
    }
  }
  if (all.empty())
    throw Error(Error::Kind::bad_data, say("no channel of {}; the recordings hold {}", Sentence(wanted.what.c_str()),
                                           Name{described(evidence.recordings)}));
  return all;
}

Extremes finite_extremes(const Channel& channel, std::size_t begin, std::size_t end, const std::string& label) {
  const auto values = std::span(channel.values).subspan(begin, end - begin);
  const Extremes extremes = extremes_of(values);
  if (!std::isinf(extremes.lowest) && !std::isinf(extremes.highest)) return extremes;
  const auto first = std::ranges::find_if(values, [](double value) { return std::isinf(value); });
  if (first == values.end()) return extremes;  // none is present
  const auto at = begin + static_cast<std::size_t>(first - values.begin());
  throw Error(Error::Kind::bad_data, say("{}: infinite at {}", Name{label}, Name{say_instant(channel.time(at))}));
}

EvenSignal even_signal(const ChannelRun& stretch, double rate, const std::string& timing) {
  EvenSignal signal;
  const Channel& channel = *stretch.channel;
  const std::span<const double> values = std::span(channel.values).subspan(stretch.begin, stretch.end - stretch.begin);
  signal.extremes = finite_extremes(channel, stretch.begin, stretch.end, stretch.label);
  if (!values.empty()) signal.begin = channel.time(stretch.begin);
  signal.values = values;
  if (rate > 0.0) {
    signal.rate = rate;
    const double stamped = mean_rate(channel);
    if (stamped > 0.0 && std::abs(rate / stamped - 1.0) > rate_differs)
      signal.findings.push_back({Severity::warning,
                                 "rate_differs_from_file",
                                 {{"rate", rate, "Hz"}, {"stamped", stamped, "Hz"}},
                                 stretch.label});
    return signal;
  }
  if (channel.timeline.uniform()) {
    signal.rate = channel.timeline.rate;
  } else if (values.size() > 1) {
    by_clock(stretch, timing, signal);
    if (!signal.made.empty()) {
      signal.values = signal.made;
      signal.extremes = extremes_of(signal.made);
    }
  }
  return signal;
}

Sentence unusable(const Extremes& extremes, std::size_t samples, double rate) {
  constexpr std::size_t fewest = 16;
  if (samples == 0) return "holds no sample";
  if (extremes.present == 0) return "holds no number, only missing samples";
  if (extremes.present < fewest)
    return say("holds {}, too few: at least {} are needed", said_count(extremes.present, "sample"), fewest);
  if (extremes.lowest == extremes.highest) return "does not change: stuck, or not connected";
  if (!(rate > 0.0)) return "has no sampling rate: give rate=... in Hz";
  return {};
}

Sentence unusable(const EvenSignal& signal) { return unusable(signal.extremes, signal.values.size(), signal.rate); }

Scatter scatter_of(std::span<const double> values, std::size_t first) {
  constexpr std::size_t lanes = 4;
  const auto start = std::find_if(values.begin(), values.end(), [](double value) { return !std::isnan(value); });
  if (start == values.end()) return {0.0, 0.0, 0.0, first};
  const double origin = *start;
  double sums[lanes] = {}, squares[lanes] = {}, count = static_cast<double>(values.size());
  const auto add = [&](double value, std::size_t lane) {
    sums[lane] += value - origin;
    squares[lane] += (value - origin) * (value - origin);
  };
  const std::size_t in_lanes = values.size() / lanes * lanes;
  for (std::size_t n = 0; n < in_lanes; n += lanes)
    for (std::size_t k = 0; k < lanes; ++k) add(values[n + k], k);
  for (std::size_t n = in_lanes; n < values.size(); ++n) add(values[n], 0);
  double sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  double square = (squares[0] + squares[1]) + (squares[2] + squares[3]);
  if (std::isnan(sum)) {
    sum = square = count = 0.0;
    for (const double value : values) {
      if (std::isnan(value)) continue;
      sum += value - origin;
      square += (value - origin) * (value - origin);
      ++count;
    }
  }
  const double mean = sum / count;
  return {count, origin + mean, std::sqrt(std::max(0.0, square / count - mean * mean)), first};
}

BlockScatter block_scatter(std::span<const double> values) {
  BlockScatter scatter{std::max<std::size_t>(least_block, values.size() / most_blocks), {}};
  for (std::size_t first = 0; first + scatter.size <= values.size(); first += scatter.size)
    scatter.blocks.push_back(scatter_of(values.subspan(first, scatter.size), first));
  return scatter;
}

Findings disturbances(const EvenSignal& signal, const std::string& label) {
  const BlockScatter scatter = block_scatter(signal.values);
  return disturbances(scatter.blocks, scatter.size, signal.rate, signal.begin, label);
}

Findings disturbances(const std::vector<Scatter>& blocks, std::size_t size, double rate, double begin,
                      const std::string& label) {
  constexpr double unusual = 4.0;
  std::vector<double> sds;
  for (const auto& block : blocks)
    if (block.count > 0.0) sds.push_back(block.sd);
  if (sds.size() < fewest_blocks) return {};
  std::nth_element(sds.begin(), sds.begin() + static_cast<std::ptrdiff_t>(sds.size() / 2), sds.end());
  const double usual = sds[sds.size() / 2];
  const auto place = [&](const Scatter& block) { return Place(begin + static_cast<double>(block.first) / rate); };
  Occurrences often{0, {}, {}};
  double greatest = unusual * usual;
  for (const auto& block : blocks) {
    if (!(usual > 0.0 && block.count > 0.0 && block.sd > unusual * usual)) continue;
    if (often.count++ == 0) often.first = place(block);
    if (block.sd > greatest) often.worst = place(block), greatest = block.sd;
  }
  if (often.count == 0) return {};
  return {{Severity::warning,
           "disturbed_blocks",
           {{"blocks", sds.size()}, {"length", static_cast<double>(size) / rate, "s"}, {"limit", unusual}},
           label,
           often}};
}

}  // namespace tumble
