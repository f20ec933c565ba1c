#include "tumble/recorder/live_store/front.hpp"

#include <algorithm>
#include <cmath>

namespace tumble::live_store {

std::size_t Front::add_link(const StoreLink& link) {
  batch_.links.emplace_back(links_, json_of(link));
  return links_++;
}

std::size_t Front::add_stream(const StoreStream& stream) {
  batch_.streams.emplace_back(streams_, json_of(stream));
  return streams_++;
}

/// `whole`: the item is a chunk of its own, which is not to wait.
template <class Put>
std::uint64_t Front::append(StoreItem::Kind kind, std::size_t source, double time, bool whole, Put put) {
  const auto place = open_.try_emplace({kind, source}).first;
  Chunk& chunk = place->second;
  chunk.kind = kind;
  chunk.source = source;
  const std::size_t before = chunk.body.size();
  put(chunk, ++last_);
  time_ = std::fmax(time_, time);
  bytes_ += chunk.body.size() - before;
  all_bytes_ += chunk.body.size() - before;
  ++items_;
  if (whole || chunk.body.size() >= chunk_bytes_) {
    batch_.chunks.push_back(std::move(chunk));
    open_.erase(place);
    urgent_ = urgent_ || whole || bytes_ >= commit_bytes_;
  }
  return last_;
}

std::uint64_t Front::raw(std::size_t link, StoreDirection direction, double time, std::string_view bytes) {
  return append(StoreItem::Kind::raw, link, time, false,
                [&](Chunk& chunk, std::uint64_t sequence) { put_raw(chunk, sequence, direction, time, bytes); });
}

std::uint64_t Front::sample(std::size_t stream, const StoreSample& sample) {
  return append(StoreItem::Kind::sample, stream, sample.time, false,
                [&](Chunk& chunk, std::uint64_t sequence) { put_sample(chunk, sequence, sample); });
}

std::uint64_t Front::event(const StoreEvent& event) {
  return append(StoreItem::Kind::event, 0, event.time, true,
                [&](Chunk& chunk, std::uint64_t sequence) { put_event(chunk, sequence, event); });
}

std::uint64_t Front::journal(double time, const RunRow& row) {
  return append(StoreItem::Kind::journal, 0, time, true,
                [&](Chunk& chunk, std::uint64_t sequence) { put_journal(chunk, sequence, time, row); });
}

Batch Front::take() {
  for (auto& [place, chunk] : open_) batch_.chunks.push_back(std::move(chunk));
  open_.clear();
  std::ranges::sort(batch_.chunks, {}, &Chunk::first);
  batch_.last = last_;
  batch_.time = time_;
  bytes_ = 0;
  urgent_ = false;
  return std::exchange(batch_, {});
}

void Front::put_back(Batch batch) {
  for (const Chunk& chunk : batch.chunks) bytes_ += chunk.body.size();
  std::ranges::move(batch_.chunks, std::back_inserter(batch.chunks));
  std::ranges::move(batch_.links, std::back_inserter(batch.links));
  std::ranges::move(batch_.streams, std::back_inserter(batch.streams));
  for (auto& [name, value] : batch_.facts) batch.facts[name] = value;
  batch_ = std::move(batch);
}

}  // namespace tumble::live_store
