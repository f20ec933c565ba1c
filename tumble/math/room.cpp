#include "tumble/math/room.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <cstdint>

namespace tumble {

void in_large_pages([[maybe_unused]] void* begin, [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  constexpr std::uintptr_t page = std::uintptr_t{1} << 21;
  const auto at = reinterpret_cast<std::uintptr_t>(begin);
  const auto first = (at + page - 1) / page * page, last = (at + bytes) / page * page;
  if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);  // advice: may be refused
#endif
}

void make_room(std::vector<double>& values, std::size_t count) {
  values.reserve(count);
  in_large_pages(values.data(), values.capacity() * sizeof(double));
}

}  // namespace tumble
