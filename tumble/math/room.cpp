#include "tumble/math/room.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <memory>
#include <mutex>
#include <new>
#include <thread>

namespace tumble {
namespace {

constexpr std::size_t large_page = std::size_t{1} << 21;

/// Memory about to be written for the first time: in large pages where the system has them.
void in_large_pages([[maybe_unused]] void* begin, [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  if (std::align(large_page, large_page, begin, bytes))
    madvise(begin, bytes / large_page * large_page, MADV_HUGEPAGE);  // advice: may be refused
#endif
}

bool is_long(std::size_t count) { return count * sizeof(double) > 4 * large_page; }

std::align_val_t alignment_of(std::size_t count) { return std::align_val_t{is_long(count) ? large_page : 64}; }

/// Values that fill the last large page, so that a slightly longer record fits too.
std::size_t filled_up(std::size_t count) {
  constexpr std::size_t page = large_page / sizeof(double);
  return is_long(count) ? (count + page - 1) / page * page : count;
}

/// What was given back, as many as there are threads to need it again.
struct Block {
  double* values;
  std::size_t count;
};
struct Spare {
  std::mutex guard;
  std::vector<Block> blocks;
};
Spare& spare() {
  static Spare& kept = *new Spare;  // outlives all that may give back
  return kept;
}

void let_go(const Block& block) { operator delete[](block.values, alignment_of(block.count)); }

/// A spare one that is long enough, and not far too long: the last that came back.
Block find_spare(std::size_t count) {
  const std::lock_guard lock(spare().guard);
  auto& blocks = spare().blocks;
  const auto fits = [&](const Block& block) { return block.count >= count && block.count / 2 <= count; };
  const auto found = std::find_if(blocks.rbegin(), blocks.rend(), fits);
  if (found == blocks.rend()) return {};
  const Block block = *found;
  blocks.erase(std::next(found).base());
  return block;
}

std::size_t doubles_of(std::size_t bytes) { return filled_up((bytes + sizeof(double) - 1) / sizeof(double)); }

}  // namespace

void make_room(std::vector<double>& values, std::size_t count) {
  values.reserve(count);
  in_large_pages(values.data(), values.capacity() * sizeof(double));
}

Room borrow_room(std::size_t wanted) {
  const std::size_t count = filled_up(wanted);
  if (is_long(count))
    if (const Block block = find_spare(count); block.values) return {block.values, GiveBack{block.count}};
  auto* const values = static_cast<double*>(operator new[](count * sizeof(double), alignment_of(count)));
  if (is_long(count)) in_large_pages(values, count * sizeof(double));
  return {values, GiveBack{count}};
}

void GiveBack::operator()(double* values) const {
  if (!is_long(count)) return let_go({values, count});
  const std::lock_guard lock(spare().guard);
  auto& blocks = spare().blocks;
  blocks.push_back({values, count});
  if (blocks.size() <= std::max(1u, std::thread::hardware_concurrency())) return;
  let_go(blocks.front());
  blocks.erase(blocks.begin());
}

void* take_room(std::size_t bytes) { return borrow_room(doubles_of(bytes)).release(); }

void give_room(void* memory, std::size_t bytes) { GiveBack{doubles_of(bytes)}(static_cast<double*>(memory)); }

}  // namespace tumble
