#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "tumble/recorder/live_store/chunk.hpp"

namespace tumble::live_store {

/// The items of a batch in the order of their sequence numbers.
class Order {
 public:
  explicit Order(const std::vector<StoreStream>& streams) : streams_(streams) {}
  /// The chunk lives until hand_out(). False: its body is not what its kind needs.
  bool add(const Chunk& chunk);
  void hand_out(const std::function<void(const StoreItem&)>& visit);

 private:
  struct Entry {
    StoreItem item;
    std::size_t values = 0;  ///< where those of a sample begin
  };
  const std::vector<StoreStream>& streams_;
  std::vector<Entry> entries_;
  std::vector<double> values_;
  std::deque<StoreEvent> events_;
  std::deque<RunRow> rows_;
};

}  // namespace tumble::live_store
