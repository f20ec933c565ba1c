#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tumble/wire/frames.hpp"

namespace tumble::codec {

/// [byte] of a frame that `end` means: what is negative, or 0 where it is an end, counts from the end of the frame.
inline int place_in(int length, int at, bool is_end) { return at < 0 || (is_end && at == 0) ? length + at : at; }

/// The tables of a CRC by byte, for eight bytes at once (Kounavis and Berry 2005): the last byte first. Empty for other
/// checksums.
std::vector<std::uint32_t> crc_table(const FrameChecksum& check);

/// The checksum of a frame as it should stand at `check.at`. The ranges must lie in the frame.
std::uint32_t checksum_of(const FrameChecksum& check, std::string_view frame);

/// The checksum of these bytes.
std::uint32_t checksum_over(const FrameChecksum& check, std::string_view range);

/// Whether the frame has room for the checksum and its ranges.
bool has_room(const FrameChecksum& check, std::size_t length);

/// Whether the checksum that stands in the frame is right. The frame must have room for it.
bool holds(const FrameChecksum& check, std::string_view frame);

void put_checksum(const FrameChecksum& check, std::string& frame);

}  // namespace tumble::codec
