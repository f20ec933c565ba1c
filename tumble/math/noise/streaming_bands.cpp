#include "tumble/math/noise/streaming_bands.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "tumble/units/error.hpp"

namespace tumble {

StreamingNoiseBands::StreamingNoiseBands(std::size_t start, std::size_t total) : start_(start), total_(total) {
  std::size_t first = start, values = total;
  for (; values >= values_for_widest; values /= widest_block) {
    const std::size_t block = (first + widest_block - 1) / widest_block;
    Scale& scale = scales_.emplace_back();
    scale.lead_size = block * widest_block - first;
    scale.passed = true;
    scale.sums = ScaleSums(block, values / widest_block);
    first = block;
  }
  scales_.emplace_back();
}

void StreamingNoiseBands::push(std::span<const double> rate) {
  samples_ += rate.size();
  push(0, rate);
}

void StreamingNoiseBands::push(std::size_t index, std::span<const double> values) {
  constexpr std::size_t slice = 8192;
  if (index == scales_.size()) scales_.emplace_back();
  Scale& scale = scales_[index];
  const auto leading = values.first(std::min(scale.lead_size - scale.lead.size(), values.size()));
  scale.lead.insert(scale.lead.end(), leading.begin(), leading.end());
  values = values.subspan(leading.size());
  while (!values.empty()) {
    if (scale.passed && scale.kept.empty() && values.size() >= widest_block) {
      const std::size_t whole = std::min(slice, values.size() / widest_block * widest_block);
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
    for (std::size_t first = 0; first < kept.size(); first += slice)
      take(index, std::span(kept).subspan(first, std::min(slice, kept.size() - first)));
  }
}

void StreamingNoiseBands::take(std::size_t index, std::span<const double> blocks) {
  static const BlockCosines cosines(widest_block);
  std::vector<double> means(blocks.size() / widest_block);
  scales_[index].sums.take(cosines, blocks, means.data());
  push(index + 1, means);
}

/// From fast to slow. The lead of the next part completes the last block of this one, whose mean goes to the next
/// scale before the lead of the next part there.
void StreamingNoiseBands::append(const StreamingNoiseBands& next) {
  if (total_ == 0 || next.total_ != total_ || next.start_ != start_ + samples_)
    throw Error(Error::Kind::bad_input,
                say("the part that starts at sample {} does not follow one that ends at {}, or is of another record",
                    Name{std::to_string(next.start_)}, Name{std::to_string(start_ + samples_)}));
  samples_ += next.samples_;
  for (std::size_t k = 0; k < scales_.size(); ++k) {
    const Scale& other = next.scales_[k];
    push(k, other.lead);
    Scale& scale = scales_[k];
    if (!scale.passed) {
      scale.kept.insert(scale.kept.end(), other.kept.begin(), other.kept.end());
    } else if (other.lead.size() == other.lead_size) {
      scale.sums.append(other.sums);
      push(k, other.kept);
    }
  }
}

/// Groups of the fastest contrasts as 16 nearly equal parts.
void StreamingNoiseBands::add_parts(NoiseBands& result) const {
  if (scales_.empty() || !scales_.front().passed) return;
  const ScaleSums& sums = scales_.front().sums;
  const std::size_t groups = sums.groups().size();
  const std::size_t all = (groups - 1) * sums.group_blocks() + sums.last_blocks();
  std::vector<ContrastGroup> equal(NoiseBands::parts, ContrastGroup{0.0, {}});
  for (std::size_t i = 0, done = 0; i < groups; ++i) {
    const std::size_t blocks = i + 1 < groups ? sums.group_blocks() : sums.last_blocks();
    equal[(2 * done + blocks) * NoiseBands::parts / (2 * all)].add(sums.groups()[i]);
    done += blocks;
  }
  for (const ContrastGroup& part : equal) result.add_part(part, widest_block);
}

NoiseBands StreamingNoiseBands::bands() const {
  NoiseBands result;
  add_parts(result);
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
