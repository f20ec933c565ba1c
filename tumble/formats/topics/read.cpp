#include "tumble/formats/topics/read.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/formats/file/even_clock.hpp"
#include "tumble/formats/file/number_at.hpp"
#include "tumble/math/room.hpp"

namespace tumble::topics {

std::size_t size_of(Number number) {
  static constexpr unsigned char sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return sizes[static_cast<std::size_t>(number)];
}

bool is_integer(Number number) { return number != Number::f32 && number != Number::f64; }

namespace {

constexpr double place = 1e-6;  ///< [s] of the last digit of a stamp

/// Where a value of a column goes, and how it becomes SI.
struct Conversion {
  double factor, offset;
};

/// The samples of one topic that are in memory.
struct Samples {
  std::vector<double> stamps;               ///< [s]
  std::vector<std::vector<double>> values;  ///< [SI] by column
  std::vector<Conversion> conversions;
  std::size_t infinite = 0;
};

Samples samples_of(const Topic& topic) {
  Samples samples;
  for (const Column& column : topic.columns)
    samples.conversions.push_back({column.scale * column.unit->factor(), column.unit->offset()});
  samples.values.resize(topic.columns.size());
  return samples;
}

/// NaN for an infinite value, which is counted.
double finite(double value, std::size_t& infinite) {
  if (!std::isinf(value)) [[likely]]
    return value;
  ++infinite;
  return std::numeric_limits<double>::quiet_NaN();
}

std::size_t samples_in(const Topic& topic, const char* message) {
  if (!topic.burst) return 1;
  return std::min<std::size_t>(static_cast<unsigned char>(message[topic.burst->count]), topic.burst->capacity);
}

double stamp_of(const Topic& topic, const char* message) {
  const double later = topic.later ? file::number_at<std::int32_t>(message + *topic.later) : 0.0;
  return (number_at(message + topic.time, topic.time_number) + later) / topic.ticks;
}

/// [s] between the samples of a burst.
double interval_of(const Burst& burst, const char* message) {
  const double interval = file::number_at<float>(message + burst.interval) / 1e6;
  return interval >= 0.0 && interval <= 1.0 ? interval : 0.0;
}

template <class Stamp>
void each_stamp(const Topic& topic, const char* message, const Stamp& stamp) {
  const double last = stamp_of(topic, message);
  if (!topic.burst) return stamp(last);
  const double interval = interval_of(*topic.burst, message);
  for (std::size_t k = samples_in(topic, message); k-- > 0;) stamp(last - static_cast<double>(k) * interval);
}

void append_burst(const Topic& topic, const char* message, Samples& to) {
  const std::size_t count = samples_in(topic, message);
  const double scale = file::number_at<float>(message + topic.burst->scale);
  for (std::size_t i = 0; i < topic.columns.size(); ++i) {
    const Column& column = topic.columns[i];
    const std::size_t size = size_of(column.number);
    const Conversion& si = to.conversions[i];
    for (std::size_t k = 0; k < count; ++k) {
      const double value = number_at(message + column.offset + k * size, column.number) * scale;
      to.values[i].push_back(finite(value * si.factor + si.offset, to.infinite));
    }
  }
}

void append(const Topic& topic, const char* message, Samples& to) {
  if (topic.burst) {
    each_stamp(topic, message, [&](double stamp) { to.stamps.push_back(stamp); });
    return append_burst(topic, message, to);
  }
  to.stamps.push_back(stamp_of(topic, message));
  for (std::size_t i = 0; i < topic.columns.size(); ++i) {
    const Column& column = topic.columns[i];
    const Conversion& si = to.conversions[i];
    const double value = number_at(message + column.offset, column.number);
    to.values[i].push_back(finite(value * si.factor + si.offset, to.infinite));
  }
}

/// The channels of the log, topic after topic, without samples.
Recording frame_of(const Log& log) {
  Recording frame = log.frame;
  for (const Topic& topic : log.topics)
    for (const Column& column : topic.columns)
      frame.channels.push_back({column.names.front(), kind_of(*column.unit), *column.unit, {}, {}});
  return frame;
}

void say_infinite(const Log& log, const std::vector<Samples>& samples, Findings& findings) {
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (samples[i].infinite > 0)
      findings.push_back({Finding::Severity::warning,
                          "infinite_samples",
                          {{"topic", log.topics[i].name}},
                          "",
                          {samples[i].infinite, {}, {}}});
}

Timeline kept(std::vector<double>&& stamps) {
  return {0.0, 0.0, std::make_shared<const std::vector<double>>(std::move(stamps))};
}

/// Moves samples and stamps to the channels; an even clock says the time from sample `first` on.
void hand_over(const Log& log, const std::vector<std::optional<Timeline>>& clocks,
               const std::vector<std::size_t>& first, std::vector<Samples>& samples, Recording& to) {
  std::size_t channel = 0;
  for (std::size_t i = 0; i < log.topics.size(); ++i) {
    const auto& clock = clocks[i];
    const Timeline timeline =
        clock ? Timeline{clock->time(first[i]), clock->rate, nullptr} : kept(std::move(samples[i].stamps));
    for (auto& values : samples[i].values) {
      to.channels[channel].timeline = timeline;
      to.channels[channel++].values = std::move(values);
      values = {};
    }
    samples[i].stamps = {};
  }
}

std::optional<Timeline> clock_of(const std::vector<double>& stamps, std::optional<double> rate) {
  file::EvenClock clock;
  for (const double stamp : stamps) clock.add(stamp, place);
  return clock.timeline(rate);
}

/// The even clocks, found in a pass over the stamps alone.
std::vector<std::optional<Timeline>> clocks_of(const Log& log, std::optional<double> rate) {
  std::vector<file::EvenClock> clocks(log.topics.size());
  log.play(
      [&](std::size_t topic, const char* message) {
        each_stamp(log.topics[topic], message, [&](double stamp) { clocks[topic].add(stamp, place); });
      },
      {});
  std::vector<std::optional<Timeline>> timelines;
  for (const auto& clock : clocks) timelines.push_back(clock.timeline(rate));
  return timelines;
}

}  // namespace

Recording read(const Log& log, std::optional<double> rate, const Progress& progress) {
  Recording recording = frame_of(log);
  std::vector<Samples> samples;
  for (const Topic& topic : log.topics) {
    samples.push_back(samples_of(topic));
    if (topic.burst) continue;
    make_room(samples.back().stamps, topic.messages);
    for (auto& values : samples.back().values) make_room(values, topic.messages);
  }
  log.play([&](std::size_t topic, const char* message) { append(log.topics[topic], message, samples[topic]); },
           progress);
  say_infinite(log, samples, recording.findings);
  std::vector<std::optional<Timeline>> clocks;
  for (const Samples& of : samples) clocks.push_back(clock_of(of.stamps, rate));
  hand_over(log, clocks, std::vector<std::size_t>(samples.size()), samples, recording);
  return recording;
}

std::uintmax_t memory(const Log& log) {
  std::uintmax_t numbers = 0;
  for (const Topic& topic : log.topics)
    numbers += (topic.columns.size() + 1) * topic.messages * (topic.burst ? topic.burst->capacity : 1);
  return numbers * sizeof(double);
}

void stream(const Log& log, std::optional<double> rate, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  const auto clocks = clocks_of(log, rate);
  Recording block = frame_of(log);
  std::vector<Samples> pending;
  for (const Topic& topic : log.topics) pending.push_back(samples_of(topic));
  std::vector<std::size_t> first(log.topics.size());
  const auto send = [&] {
    std::vector<std::size_t> next = first;
    for (std::size_t i = 0; i < pending.size(); ++i) next[i] += pending[i].stamps.size();
    say_infinite(log, pending, block.findings);
    hand_over(log, clocks, first, pending, block);
    sink(block);
    block.findings.clear();
    for (Samples& of : pending) of.infinite = 0;
    first = std::move(next);
  };
  log.play(
      [&](std::size_t topic, const char* message) {
        append(log.topics[topic], message, pending[topic]);
        if (pending[topic].stamps.size() >= samples) send();
      },
      progress);
  if (std::ranges::any_of(pending, [](const Samples& of) { return !of.stamps.empty(); })) send();
}

}  // namespace tumble::topics
