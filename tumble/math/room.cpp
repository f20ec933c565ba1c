#include "tumble/math/room.hpp"

#include <sys/mman.h>

#include <cstdint>

namespace tumble {

void make_room(std::vector<double>& values, std::size_t count) {
  values.reserve(count);
  constexpr std::uintptr_t page = std::uintptr_t{1} << 21;
  const auto begin = (reinterpret_cast<std::uintptr_t>(values.data()) + page - 1) / page * page;
  const auto end = reinterpret_cast<std::uintptr_t>(values.data() + values.capacity()) / page * page;
  if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);  // advice: may be refused
}

}  // namespace tumble
