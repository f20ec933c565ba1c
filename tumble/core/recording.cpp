#include "tumble/core/recording.hpp"

namespace tumble {

std::string sha256_of(const Origin& origin) { return origin.checksum ? origin.checksum() : ""; }

const Channel* find_channel(const Recording& recording, std::string_view name) {
  for (const Channel& channel : recording.channels)
    if (channel.name == name) return &channel;
  return nullptr;
}

}  // namespace tumble
