#pragma once

#include <functional>

#include "tumble/recorder/live_store/chunk.hpp"

namespace tumble::live_store {

/// Makes `text` the body of a chunk of one item, which happened at `time` [s].
void put_text(Chunk& chunk, std::uint64_t sequence, double time, std::string text);
/// items_of() for events and rows of the journal.
bool items_of_text(const Chunk& chunk, const std::function<void(const StoreItem&)>& visit);

}  // namespace tumble::live_store
