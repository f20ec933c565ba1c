#include "tumble/core/recording.hpp"

namespace tumble {

const Channel* find_channel(const Recording& recording, std::string_view name) {
  for (const Channel& channel : recording.channels)
    if (channel.name == name) return &channel;
  return nullptr;
}

}  // namespace tumble
