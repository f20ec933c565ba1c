#include "tumble/math/room.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "tumble/math/parallel.hpp"

namespace {

using tumble::borrow_room;

constexpr std::size_t record = 4000000;  // 32 MB

TEST(Room, BeginsWithALineOfTheCache) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{1000}, record})
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(borrow_room(count).get()) % 64, 0u) << count;
}

TEST(Room, OfARecordIsLentAgain) {
  double* const first = borrow_room(record).get();  // given back at once
  auto again = borrow_room(record - 1000);
  EXPECT_EQ(again.get(), first);
  const auto beside = borrow_room(record);
  EXPECT_NE(beside.get(), first);
  again.reset();
  EXPECT_NE(borrow_room(record / 3).get(), first);  // would keep far more than it needs
  EXPECT_GE(borrow_room(record + 1).get_deleter().count, record + 1);
}

TEST(Room, BelongsToOneThreadAtATime) {
  std::vector<int> torn(64, 0);
  tumble::parallel_for(torn.size(), [&](std::size_t i) {
    const auto room = borrow_room(record);
    const double mark = static_cast<double>(i);
    for (std::size_t k = 0; k < record; k += 4096) room[k] = mark;
    for (std::size_t k = 0; k < record; k += 4096) torn[i] += room[k] != mark;
  });
  EXPECT_EQ(torn, std::vector<int>(64, 0));
}

}  // namespace
