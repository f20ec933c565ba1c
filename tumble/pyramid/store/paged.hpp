#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

namespace tumble::store {

/// Values that lie in pages of one size: one page of a file, or many that are shared by views of something that grows.
template <class Value>
struct Paged {
  std::vector<const Value*> pages;
  unsigned shift = 62;  ///< of an index, to that of its page

  Paged() = default;
  explicit Paged(const Value* all) : pages{all} {}
  const Value& operator[](std::size_t i) const { return pages[i >> shift][i & ((std::size_t{1} << shift) - 1)]; }
};

/// Hands out what a vector that grows has at a moment. What is complete is copied once, into pages that all share; the
/// rest, which may change, is copied each time.
template <class Value>
class SharedPages {
 public:
  using Page = std::shared_ptr<const std::vector<Value>>;

  /// Given: the values, of which the first `complete` will never change.
  Paged<Value> share(const std::vector<Value>& values, std::size_t complete,
                     std::vector<std::shared_ptr<const void>>& owners) {
    constexpr unsigned shift = 12;
    constexpr std::size_t size = std::size_t{1} << shift;
    const auto page = [&](std::size_t first) {
      const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first);
      return std::make_shared<const std::vector<Value>>(
          begin, begin + static_cast<std::ptrdiff_t>(std::min(size, values.size() - first)));
    };
    while ((whole_.size() + 1) * size <= complete) whole_.push_back(page(whole_.size() * size));
    Paged<Value> paged;
    paged.shift = shift;
    const auto add = [&](const Page& one) {
      paged.pages.push_back(one->data());
      owners.push_back(one);
    };
    for (const Page& one : whole_) add(one);
    for (std::size_t first = whole_.size() * size; first < values.size(); first += size) add(page(first));
    return paged;
  }

 private:
  std::vector<Page> whole_;
};

}  // namespace tumble::store
