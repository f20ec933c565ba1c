#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/formats/file/number_at.hpp"

namespace tumble::topics {

/// How a number lies in a message, little endian.
enum class Number : unsigned char { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };

std::size_t size_of(Number number);  ///< [bytes]
bool is_integer(Number number);

/// The number at `at` [as written].
inline double number_at(const char* at, Number number) {
  switch (number) {
    case Number::i8:
      return file::number_at<std::int8_t>(at);
    case Number::u8:
      return file::number_at<std::uint8_t>(at);
    case Number::i16:
      return file::number_at<std::int16_t>(at);
    case Number::u16:
      return file::number_at<std::uint16_t>(at);
    case Number::i32:
      return file::number_at<std::int32_t>(at);
    case Number::u32:
      return file::number_at<std::uint32_t>(at);
    case Number::i64:
      return static_cast<double>(file::number_at<std::int64_t>(at));
    case Number::u64:
      return static_cast<double>(file::number_at<std::uint64_t>(at));
    case Number::f32:
      return file::number_at<float>(at);
    case Number::f64:
      break;
  }
  return file::number_at<double>(at);
}

/// A field of the messages that becomes a channel.
struct Column {
  std::string field;               ///< its name in the file: "GyrX"
  std::vector<std::string> names;  ///< of the channel: the first that is free is taken, at last topic.field
  std::optional<Unit> unit;        ///< empty: the file does not say, and nobody knows
  std::size_t offset = 0;          ///< [bytes] in the message
  Number number = Number::f32;
  double scale = 1.0;  ///< [unit] per number
};

/// Messages that hold several samples: each column is then an array.
struct Burst {
  std::size_t count = 0;     ///< offset of the number of samples, u8
  std::size_t interval = 0;  ///< offset of the time between samples [us], f32
  std::size_t scale = 0;     ///< offset of the value of one count, f32
  std::size_t capacity = 0;  ///< samples that a message has room for
};

/// One stream of a log that is read.
struct Topic {
  std::string name;  ///< "sensor_gyro:0"
  std::vector<Column> columns = {};
  std::size_t time = 0;  ///< offset of the stamp, of the last sample of a burst
  Number time_number = Number::u64;
  double ticks = 1e6;                     ///< [1/s] of the stamp
  std::optional<std::size_t> later = {};  ///< offset of an i32 [ticks] to be added to the stamp
  std::optional<Burst> burst = {};
  std::size_t messages = 0;  ///< in the file
};

/// Receives each message of a topic: the index in Log::topics, and where the message begins.
using Take = std::function<void(std::size_t topic, const char* message)>;

/// A log that has been looked through.
struct Log {
  Recording frame;            ///< file, meta and findings; no channels
  std::vector<Topic> topics;  ///< those that are read; none may be empty
  /// Goes through the file and hands out the messages of `topics`, each with all bytes that its columns need.
  std::function<void(const Take&, const Progress&)> play;
};

}  // namespace tumble::topics
