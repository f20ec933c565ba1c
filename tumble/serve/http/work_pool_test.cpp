#include "tumble/serve/http/work_pool.hpp"

#include <gtest/gtest.h>

#include <future>

namespace tumble::http {
namespace {

/// Work that says that it has begun, and ends when it is let go.
struct Gate {
  std::promise<void> begun, opened;
  std::shared_future<void> open = opened.get_future().share();
  WorkPool::Work work() {
    return [this] {
      begun.set_value();
      open.wait();
    };
  }
};

TEST(WorkPool, PartiesTakeTurns) {
  Gate gate;
  std::string order;
  std::promise<void> last;
  WorkPool pool(1, 1);
  pool.post("first", gate.work());
  gate.begun.get_future().wait();
  for (int i = 0; i < 5; ++i) pool.post("greedy", [&] { order += 'g'; });
  pool.post("modest", [&] { order += 'm'; });
  for (int i = 0; i < 2; ++i) pool.post("other", [&] { order += 'o'; });
  pool.post("greedy", [&] { last.set_value(); });
  EXPECT_EQ(pool.pending("greedy"), 6u);
  EXPECT_EQ(pool.pending("nobody"), 0u);
  gate.opened.set_value();
  last.get_future().wait();
  EXPECT_EQ(order, "gmogoggg");
}

TEST(WorkPool, OnePartyNeverHasAllThreads) {
  Gate first, second, third, other;
  WorkPool pool(3, 2);
  pool.post("greedy", first.work());
  pool.post("greedy", second.work());
  pool.post("greedy", third.work());
  first.begun.get_future().wait();
  second.begun.get_future().wait();
  pool.post("modest", other.work());
  other.begun.get_future().wait();  // would wait for ever behind the third
  auto begun = third.begun.get_future();
  EXPECT_EQ(begun.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  first.opened.set_value();
  begun.wait();
  for (Gate* gate : {&second, &third, &other}) gate->opened.set_value();
}

}  // namespace
}  // namespace tumble::http
