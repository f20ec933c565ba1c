#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/formats/topics/number.hpp"

namespace tumble::topics {

/// A field of the messages that becomes a channel.
struct Column {
  std::string field;               ///< its name in the file: "GyrX"
  std::vector<std::string> names;  ///< of the channel: the first that is free is taken, at last topic.field
  std::optional<Unit> unit;        ///< empty: the file does not say, and nobody knows
  std::size_t offset = 0;          ///< [bytes] in the message, or behind its header
  Number number = Number::f32;
  double scale = 1.0;  ///< [unit] per number

  const std::string& name() const { return names.front(); }  ///< of the channel, once name_columns() has chosen it
};

/// Messages that hold several samples: each column is then an array.
struct Burst {
  std::size_t count = 0;     ///< offset of the number of samples, u8
  std::size_t interval = 0;  ///< offset of the time between samples [us], f32
  std::size_t scale = 0;     ///< offset of the value of one count, f32
  std::size_t capacity = 0;  ///< samples that a message has room for
};

/// Where the time lies in messages that all have one layout.
struct Layout {
  std::size_t time = 0;  ///< offset of the stamp, of the last sample of a burst
  Number time_number = Number::u64;
  double ticks = 1e6;                     ///< [1/s] of the stamp
  std::optional<std::size_t> later = {};  ///< offset of an i32 [ticks] to be added to the stamp
  std::optional<Burst> burst = {};
};

/// One stream of a log that is read.
struct Topic {
  std::string name;         ///< "sensor_gyro:0"
  std::size_t source = 0;   ///< the number by which the log knows it
  std::string type = {};    ///< of its messages, "sensor_msgs/Imu"; empty: the name says it
  const char* other = "";   ///< code of a finding about what its messages hold and is not read; empty: nothing
  bool may_lack = false;    ///< a column that no message measures is no channel
  std::size_t samples = 0;  ///< [1] that room is made for; 0: their number is not known before
  std::size_t most = 0;     ///< [1] samples at most
  std::vector<Column> columns = {};
  Layout layout = {};
};

/// Samples of a topic, one after the other in the order of the file. The vectors may be longer than `count`.
struct Samples {
  std::vector<double> seconds;              ///< [s] of a log with one clock
  std::vector<std::int64_t> stamps;         ///< [ns] of a log with two: by the instrument
  std::vector<std::int64_t> received;       ///< [ns] and by the recorder
  std::vector<std::vector<double>> values;  ///< of each column, as written; none in a way through the stamps alone
  std::size_t count = 0;                    ///< [1]
  std::size_t unreadable = 0;               ///< messages [1] whose bytes are not what their type says
  std::vector<char> measured;               ///< of each column: some message says that it is measured
  std::string frame, other_frame;           ///< the frame of the first message, and the first that differs
};

/// Samples of all topics of a log in one stretch of it.
using Stretch = std::vector<Samples>;
/// Receives stretches in the order of the file.
using Take = std::function<void(std::span<const Stretch* const>)>;

/// Which part of the samples is wanted. A log may give the values in any case.
enum class Want { stamps, samples };

/// Facts about a log that a way through all of it has shown.
struct Played {
  Findings damage;            ///< where the file could not be read
  Findings not_read;          ///< topics that are not read
  std::vector<Sentence> why;  ///< reasons why samples may be missing, each from "; " on
};

/// A log that has been looked through.
struct Log {
  Recording frame;            ///< file, meta and findings; no channels
  std::vector<Topic> topics;  ///< those that are read; none may be empty
  bool two_clocks = false;    ///< samples have the time of the instrument and that of the recorder
  Sentence wanted = {};       ///< the topics that are read, for people
  /// Goes through the file and hands out the samples of `topics`. A log that is read by one thread hands out a stretch
  /// as soon as one topic has `samples` [1].
  std::function<Played(Want want, std::size_t samples, const Take& take, const Progress&)> play;
};

}  // namespace tumble::topics
