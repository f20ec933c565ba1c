#include "tumble/math/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <stdexcept>
#include <thread>
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

TEST(ParallelFor, WorksWithinItselfAndBesideTheBackground) {
  std::atomic<bool> stop = false;
  std::vector<std::future<void>> background;
  for (int i = 0; i < 5; ++i)  // more than there are processors
    background.push_back(in_background([&] {
      while (!stop) std::this_thread::yield();
    }));
  std::vector<std::vector<int>> calls(20, std::vector<int>(50, 0));
  parallel_for(calls.size(), [&](std::size_t i) {
    parallel_for(calls[i].size(), [&](std::size_t k) { ++calls[i][k]; });
    if (i == 10) stop = true;
  });
  for (auto& one : background) one.get();
  for (const auto& row : calls) EXPECT_EQ(row, std::vector<int>(50, 1));
  parallel_for(50, [&](std::size_t i) { ++calls[0][i]; });  // as before
  EXPECT_EQ(calls[0], std::vector<int>(50, 2));
}

TEST(ParallelFor, AnExceptionOfTheBackgroundComesOut) {
  const auto throws = [](std::size_t) { in_background([] { throw std::runtime_error("x"); }).get(); };
  EXPECT_THROW(parallel_for(4, throws), std::runtime_error);
}

// As many threads as before the background took its processor, once it has ended.
TEST(ParallelFor, HelpersComeBackWhenTheBackgroundEnds) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP();
  in_background([] {}).get();
  std::atomic<int> inside = 0;
  std::atomic<bool> together = false;
  parallel_for(2, [&](std::size_t) {
    ++inside;
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (inside < 2 && std::chrono::steady_clock::now() < until) std::this_thread::yield();
    together = together || inside == 2;
  });
  EXPECT_TRUE(together);
}

}  // namespace
}  // namespace tumble
