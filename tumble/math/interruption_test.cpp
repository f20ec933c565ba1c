#include "tumble/math/interruption.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "tumble/math/parallel.hpp"

namespace tumble {
namespace {

void wait_a_moment() { std::this_thread::sleep_for(std::chrono::microseconds(100)); }

TEST(Interruption, EndsParallelWorkOnAllThreads) {
  int asked = 0;
  std::atomic<int> done{0};
  const Interruption interruption([&] {
    if (++asked == 10) throw std::runtime_error("enough");
  });
  EXPECT_THROW(parallel_for(1'000'000,
                            [&](std::size_t) {
                              wait_a_moment();
                              ++done;
                            }),
               std::runtime_error);
  EXPECT_LT(done, 100'000);  // 9 pieces of the asking thread, and what helping threads did meanwhile
}

TEST(Interruption, ReachesWorkWithinWork) {
  std::atomic<int> done{0};
  const auto begin = std::chrono::steady_clock::now();
  const Interruption interruption([&] {
    if (std::chrono::steady_clock::now() - begin > std::chrono::milliseconds(20)) throw std::runtime_error("enough");
  });
  const auto inner = [&](std::size_t) {
    parallel_for(100'000, [&](std::size_t) {
      wait_a_moment();
      ++done;
    });
  };
  EXPECT_THROW(parallel_for(4, inner), std::runtime_error);
  EXPECT_LT(done, 400'000);
}

TEST(Interruption, IsOverWithItsLife) {
  {
    const Interruption interruption([] { throw std::runtime_error("ask nobody"); });
  }
  EXPECT_NO_THROW(stop_if_asked());
  EXPECT_NO_THROW(parallel_for(10, [](std::size_t) {}));
}

TEST(Interruption, AsksOnlyTheThreadThatBegan) {
  const auto here = std::this_thread::get_id();
  std::atomic<bool> elsewhere{false};
  const Interruption interruption([&] { elsewhere = elsewhere || std::this_thread::get_id() != here; });
  parallel_for(1000, [](std::size_t) { wait_a_moment(); });
  EXPECT_FALSE(elsewhere);
}

}  // namespace
}  // namespace tumble
