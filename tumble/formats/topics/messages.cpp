#include "tumble/formats/topics/messages.hpp"

#include <algorithm>
#include <utility>

#include "tumble/formats/file/number_at.hpp"

namespace tumble::topics {
namespace {

std::size_t samples_in(const Layout& layout, const char* message) {
  if (!layout.burst) return 1;
  return std::min<std::size_t>(static_cast<unsigned char>(message[layout.burst->count]), layout.burst->capacity);
}

double stamp_of(const Layout& layout, const char* message) {
  const double later = layout.later ? file::number_at<std::int32_t>(message + *layout.later) : 0.0;
  return (number_at(message + layout.time, layout.time_number) + later) / layout.ticks;
}

/// [s] between the samples of a burst.
double interval_of(const Burst& burst, const char* message) {
  const double interval = file::number_at<float>(message + burst.interval) / 1e6;
  return interval >= 0.0 && interval <= 1.0 ? interval : 0.0;
}

void add_stamps(const Layout& layout, const char* message, std::size_t count, double* to) {
  const double last = stamp_of(layout, message);
  if (!layout.burst) {
    *to = last;
    return;
  }
  const double interval = interval_of(*layout.burst, message);
  for (std::size_t k = count; k-- > 0;) *to++ = last - static_cast<double>(k) * interval;
}

void add_burst(const Topic& topic, const char* message, std::size_t count, Samples& to) {
  const double scale = file::number_at<float>(message + topic.layout.burst->scale);
  for (std::size_t i = 0; i < topic.columns.size(); ++i) {
    const Column& column = topic.columns[i];
    const std::size_t size = size_of(column.number);
    double* const values = to.values[i].data() + to.count;
    for (std::size_t k = 0; k < count; ++k)
      values[k] = number_at(message + column.offset + k * size, column.number) * scale;
  }
}

void make_longer(std::size_t count, Samples& to) {
  const std::size_t size = std::max<std::size_t>(1024, 2 * count);
  to.seconds.resize(size);
  for (auto& values : to.values) values.resize(size);
}

void add_message(const Topic& topic, const char* message, Samples& to) {
  const std::size_t count = samples_in(topic.layout, message);
  if (to.count + count > to.seconds.size()) make_longer(to.count + count, to);
  add_stamps(topic.layout, message, count, to.seconds.data() + to.count);
  if (topic.layout.burst && !to.values.empty())
    add_burst(topic, message, count, to);
  else
    for (std::size_t i = 0; i < to.values.size(); ++i)
      to.values[i][to.count] = number_at(message + topic.columns[i].offset, topic.columns[i].number);
  to.count += count;
}

Samples samples_of(const Topic& topic, Want want) {
  Samples samples;
  if (want == Want::samples) samples.values.resize(topic.columns.size());
  samples.measured.assign(topic.columns.size(), 1);
  return samples;
}

}  // namespace

std::size_t most_samples(const Layout& layout) { return layout.burst ? layout.burst->capacity : 1; }

void play_messages(Messages messages, Log& log) {
  log.play = [messages = std::move(messages), topics = log.topics](Want want, std::size_t samples, const Take& take,
                                                                   const Progress& progress) {
    Stretch stretch;
    for (const Topic& topic : topics) stretch.push_back(samples_of(topic, want));
    const auto hand_out = [&] {
      const Stretch* const only = &stretch;
      take({&only, 1});
      for (Samples& of : stretch) of.count = 0;
    };
    messages(
        [&](std::size_t topic, const char* message) {
          add_message(topics[topic], message, stretch[topic]);
          if (stretch[topic].count >= samples) hand_out();
        },
        progress);
    if (std::ranges::any_of(stretch, [](const Samples& of) { return of.count > 0; })) hand_out();
    return Played{};
  };
}

}  // namespace tumble::topics
