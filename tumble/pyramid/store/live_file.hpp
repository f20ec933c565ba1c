#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace tumble::store {

/// The file of LiveSamples: a signature, then records, each of a head and a payload of whole words. A record is valid
/// once all of it is there.
constexpr char live_signature[] = "TUMBLIV1";

struct LiveHead {
  enum Kind : std::uint32_t {
    text = 1,   ///< JSON: {"channel": {...}}, {"mark": {...}}, {"mark_ends": TIME}, {"fact": {...}}
    timed = 2,  ///< `count` times [s], then as many values [SI]
    values = 3  ///< `count` values [SI], whose times are those of the record before
  };
  std::uint32_t kind = 0, channel = 0, count = 0, bytes = 0;  ///< `bytes` of the payload without what fills it up

  std::uint64_t length() const { return sizeof(LiveHead) + (std::uint64_t{bytes} + 7) / 8 * 8; }
  bool plausible() const {
    const std::uint64_t numbers = std::uint64_t{count} * sizeof(double);
    return (kind == text && bytes <= 1u << 20) || (kind == timed && bytes == 2 * numbers) ||
           (kind == values && bytes == numbers);
  }
};

/// Reads exactly so many bytes; false where they are not there.
bool read_at(int descriptor, std::uint64_t place, void* to, std::size_t bytes);

/// Where the last record ends that is whole and plausible [byte]; 0: it is no such file.
std::uint64_t end_of_live_file(int descriptor, std::uint64_t size);

/// Whether somebody writes it.
bool is_written(int descriptor);

}  // namespace tumble::store
