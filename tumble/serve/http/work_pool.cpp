#include "tumble/serve/http/work_pool.hpp"

#include <utility>

namespace tumble::http {

WorkPool::WorkPool(std::size_t threads, std::size_t each) : each_(each) {
  for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
}

WorkPool::~WorkPool() {
  std::map<std::string, Party> dropped;  // destroyed without the lock
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    for (auto& [name, party] : parties_) dropped[name].waiting.swap(party.waiting);
  }
  changed_.notify_all();
  for (auto& thread : threads_) thread.join();
}

void WorkPool::post(const std::string& party, Work work) {
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    const auto [line, is_new] = parties_.try_emplace(party);
    if (is_new) line->second.served = ++turn_;  // behind those who wait already
    line->second.waiting.push_back(std::move(work));
  }
  changed_.notify_one();
}

std::size_t WorkPool::pending(const std::string& party) const {
  const std::lock_guard lock(mutex_);
  const auto found = parties_.find(party);
  return found == parties_.end() ? 0 : found->second.waiting.size() + found->second.running;
}

/// Of those who wait and may have one more thread, the one who was served the longest ago.
std::map<std::string, WorkPool::Party>::iterator WorkPool::next() {
  auto chosen = parties_.end();
  for (auto one = parties_.begin(); one != parties_.end(); ++one) {
    const Party& party = one->second;
    if (party.waiting.empty() || party.running >= each_) continue;
    if (chosen == parties_.end() || party.served < chosen->second.served) chosen = one;
  }
  return chosen;
}

void WorkPool::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    auto chosen = parties_.end();
    changed_.wait(lock, [&] { return ended_ || (chosen = next()) != parties_.end(); });
    if (ended_) return;
    Party& party = chosen->second;  // stays while it runs
    Work work = std::move(party.waiting.front());
    party.waiting.pop_front();
    party.served = ++turn_;
    ++party.running;
    lock.unlock();
    work();
    work = nullptr;
    lock.lock();
    if (--party.running == 0 && party.waiting.empty()) parties_.erase(chosen);
    changed_.notify_one();  // this thread may take another party's turn, and this party may go on with another thread
  }
}

}  // namespace tumble::http
