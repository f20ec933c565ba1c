#include "tumble/math/noise/streaming_bands.hpp"

#include <algorithm>
#include <utility>

namespace tumble {

void StreamingNoiseBands::Part::add(const Part& more) {
  blocks += more.blocks;
  contrasts += more.contrasts;
  square += more.square;
}

void StreamingNoiseBands::push(std::span<const double> rate) {
  samples_ += rate.size();
  push(0, rate);
}

void StreamingNoiseBands::push(std::size_t index, std::span<const double> values) {
  if (index == scales_.size()) scales_.emplace_back();
  Scale& scale = scales_[index];
  while (!values.empty()) {
    if (scale.passed && scale.kept.empty() && values.size() >= widest_block) {
      const std::size_t whole = values.size() / widest_block * widest_block;
      take(index, values.first(whole));
      values = values.subspan(whole);
      continue;
    }
    const std::size_t full = scale.passed ? widest_block : values_for_widest;
    const auto some = values.first(std::min(full - scale.kept.size(), values.size()));
    scale.kept.insert(scale.kept.end(), some.begin(), some.end());
    values = values.subspan(some.size());
    if (scale.kept.size() < full) return;
    scale.passed = true;
    const std::vector<double> kept = std::exchange(scale.kept, {});
    take(index, kept);
  }
}

void StreamingNoiseBands::take(std::size_t index, std::span<const double> blocks) {
  static const BlockCosines cosines(widest_block);
  double means[slice / widest_block];
  while (!blocks.empty()) {
    const auto some = blocks.first(std::min(blocks.size(), slice));
    const std::size_t count = some.size() / widest_block;
    const ContrastSums sums = scales_[index].sums.take(cosines, some, means);
    if (index == 0) note({count, sums.contrasts * (widest_block - 1), sums.square(widest_block)});
    push(index + 1, {means, count});
    blocks = blocks.subspan(some.size());
  }
}

/// Parts of the record as they come, joined two and two when they are many.
void StreamingNoiseBands::note(const Part& part) {
  if (parts_.empty() || parts_.back().blocks >= part_blocks_) {
    if (parts_.size() == most_parts) {
      for (std::size_t i = 0; i < most_parts / 2; ++i) {
        parts_[i] = parts_[2 * i];
        parts_[i].add(parts_[2 * i + 1]);
      }
      parts_.resize(most_parts / 2);
      part_blocks_ *= 2;
    }
    parts_.emplace_back();
  }
  parts_.back().add(part);
}

NoiseBands StreamingNoiseBands::bands() const {
  NoiseBands result;
  std::size_t all = 0, done = 0;
  for (const Part& part : parts_) all += part.blocks;
  std::vector<Part> equal(parts_.empty() ? 0 : NoiseBands::parts);
  for (const Part& part : parts_) {
    equal[(2 * done + part.blocks) * NoiseBands::parts / (2 * all)].add(part);
    done += part.blocks;
  }
  for (const Part& part : equal) result.add_part(part.contrasts, part.square);
  double unit = 1.0;
  std::span<const double> rest;
  for (const Scale& scale : scales_) {
    if (!scale.passed) {
      rest = scale.kept;
      break;
    }
    add_bands(scale.sums, unit, widest_block, result);
    unit *= widest_block;
  }
  result = NoiseBands(std::move(result), rest, unit);
  result.samples = samples_;
  return result;
}

}  // namespace tumble
