#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace tumble {

/// Room for `count` values, in large pages where the system has them: handing out small ones takes longer than filling
/// them. Given: values [any], empty.
void make_room(std::vector<double>& values, std::size_t count);

/// Values that are needed for a while, not set to anything, from the start of a line of the cache on. Those of a long
/// record are taken from what was given back before, and a few are kept for that: the system clears what it hands out,
/// which takes as long as to integrate it.
struct GiveBack {
  std::size_t count = 0;
  /// Gives `values` [count] back.
  void operator()(double* values) const;
};
using Room = std::unique_ptr<double[], GiveBack>;
Room borrow_room(std::size_t count);

/// Memory of `bytes` for a vector of other numbers that is needed for a while, as borrow_room() gives it; give_room()
/// takes it back.
void* take_room(std::size_t bytes);
void give_room(void* memory, std::size_t bytes);
template <class Value>
struct RoomAllocator {
  using value_type = Value;
  RoomAllocator() = default;
  template <class Other>
  RoomAllocator(const RoomAllocator<Other>&) {}  // NOLINT: as the standard asks for
  Value* allocate(std::size_t count) { return static_cast<Value*>(take_room(count * sizeof(Value))); }
  void deallocate(Value* values, std::size_t count) { give_room(values, count * sizeof(Value)); }
  bool operator==(const RoomAllocator&) const { return true; }
};

}  // namespace tumble
