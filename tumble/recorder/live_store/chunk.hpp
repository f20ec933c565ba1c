#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/recorder/recorder.hpp"
#include "tumble/recorder/recorder_read.hpp"

namespace tumble::live_store {

/// Items of one kind and source that lie in one row of the store.
struct Chunk {
  StoreItem::Kind kind = StoreItem::Kind::raw;
  std::size_t source = 0;             ///< link or stream
  std::uint64_t first = 0, last = 0;  ///< sequence numbers
  std::uint64_t count = 0;
  double begin = 0.0, end = 0.0;  ///< [s] the least and the greatest time
  std::string body;
};

// An item is put behind those of a chunk, with its sequence number.

/// Bytes of a link at `time` [s].
void put_raw(Chunk& chunk, std::uint64_t sequence, StoreDirection direction, double time, std::string_view bytes);
void put_sample(Chunk& chunk, std::uint64_t sequence, const StoreSample& sample);
void put_event(Chunk& chunk, std::uint64_t sequence, const StoreEvent& event);
void put_journal(Chunk& chunk, std::uint64_t sequence, double time, const RunRow& row);

/// Hands out the items of a chunk, whose parts live until the call returns. `channels`: of its stream. False: the body
/// is not what the kind needs.
bool items_of(const Chunk& chunk, std::size_t channels, const std::function<void(const StoreItem&)>& visit);

/// CRC-32 of the bytes of a body.
std::uint32_t checksum_of(std::string_view body);

// What a link and a stream are, as JSON and back. Throw Error::bad_file for another text.
std::string json_of(const StoreLink& link);
std::string json_of(const StoreStream& stream);
StoreLink link_of(std::string_view json);
StoreStream stream_of(std::string_view json);

}  // namespace tumble::live_store
