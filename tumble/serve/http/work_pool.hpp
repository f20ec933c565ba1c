#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace tumble::http {

/// Threads that work for several parties, who take turns: one who asks for a lot waits for himself.
class WorkPool {
 public:
  using Work = std::function<void()>;

  /// Given  threads  number of threads [1]
  ///        each     of them that work for one party at the same time [1]
  WorkPool(std::size_t threads, std::size_t each);
  WorkPool(const WorkPool&) = delete;
  WorkPool& operator=(const WorkPool&) = delete;
  /// Finishes what is being done, and drops what waits.
  ~WorkPool();

  /// Puts work in the line of its party. It must not throw.
  void post(const std::string& party, Work work);
  /// How much of this party waits or is being done.
  std::size_t pending(const std::string& party) const;

 private:
  struct Party {
    std::deque<Work> waiting;
    std::size_t running = 0;
    std::size_t served = 0;  ///< turn at which it was served last
  };
  void run();
  std::map<std::string, Party>::iterator next();

  const std::size_t each_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Party> parties_;
  std::size_t turn_ = 0;
  bool ended_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace tumble::http
