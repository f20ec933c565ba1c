#include "tumble/sim/source.hpp"

#include <algorithm>

namespace tumble {

Source::Source(std::vector<Channel> channels, std::size_t total, std::size_t portion, Make make)
    : channels_(std::move(channels)), total_(total), portion_(portion), make_(std::move(make)) {}

void Source::next(Samples out) {
  const auto advance = [&](std::size_t count) {
    for (auto& channel : out) channel = channel.subspan(count);
  };
  while (!out.front().empty()) {
    if (kept_ > 0) {
      const std::size_t count = std::min(kept_, out.front().size());
      for (std::size_t c = 0; c < out.size(); ++c)
        std::copy_n(store_[c].end() - static_cast<std::ptrdiff_t>(kept_), count, out[c].begin());
      kept_ -= count;
      advance(count);
      continue;
    }
    const std::size_t size = std::min(portion_, total_ - made_);
    if (size == 0) return;
    Samples into;
    if (size <= out.front().size()) {
      for (auto& channel : out) into.push_back(channel.first(size));
      make_(made_, into);
      advance(size);
    } else {
      store_.resize(out.size());
      for (auto& values : store_) {
        values.resize(size);
        into.emplace_back(values);
      }
      make_(made_, into);
      kept_ = size;
    }
    made_ += size;
  }
}

}  // namespace tumble
