#include "tumble/recorder/live_store/order.hpp"

#include <algorithm>

namespace tumble::live_store {

bool Order::add(const Chunk& chunk) {
  const bool sampled = chunk.kind == StoreItem::Kind::sample;
  if (sampled && chunk.source >= streams_.size()) return false;
  const std::size_t channels = sampled ? streams_[chunk.source].channels.size() : 0;
  return items_of(chunk, channels, [&](const StoreItem& item) {
    Entry& entry = entries_.emplace_back(Entry{item, values_.size()});
    values_.insert(values_.end(), item.sample.values.begin(), item.sample.values.end());
    if (item.event) entry.item.event = &events_.emplace_back(*item.event);
    if (item.journal) entry.item.journal = &rows_.emplace_back(*item.journal);
  });
}

void Order::hand_out(const std::function<void(const StoreItem&)>& visit) {
  std::ranges::sort(entries_, {}, [](const Entry& entry) { return entry.item.sequence; });
  for (Entry& entry : entries_) {
    if (entry.item.kind == StoreItem::Kind::sample)
      entry.item.sample.values = {values_.data() + entry.values, entry.item.sample.values.size()};
    visit(entry.item);
  }
  entries_.clear();
  values_.clear();
  events_.clear();
  rows_.clear();
}

}  // namespace tumble::live_store
