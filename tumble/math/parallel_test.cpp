#include "tumble/math/parallel.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace tumble {
namespace {

TEST(ParallelFor, CallsEachIndexOnce) {
  for (const std::size_t count : {0u, 1u, 2u, 1000u}) {
    std::vector<int> calls(count, 0);
    parallel_for(count, [&](std::size_t i) { ++calls[i]; });
    EXPECT_EQ(calls, std::vector<int>(count, 1));
  }
}

TEST(ParallelFor, AnExceptionComesOut) {
  const auto throws_at_seven = [](std::size_t i) {
    if (i == 7) throw std::runtime_error("seven");
  };
  EXPECT_THROW(parallel_for(100, throws_at_seven), std::runtime_error);
}

}  // namespace
}  // namespace tumble
