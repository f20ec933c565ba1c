#include "tumble/formats/file/gathered.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tumble/formats/file/shares.hpp"

namespace tumble::file {
namespace {

using Stamps = std::shared_ptr<const std::vector<double>>;

void scale(std::vector<double>& values, double factor, double offset) {
  if (factor == 1.0 && offset == 0.0) return;
  for (double& value : values) value = value * factor + offset;
}

void make_si(const Source& source, bool infinite, const Unit& unit, std::vector<double>& values) {
  if (infinite)
    for (double& value : values)
      if (std::isinf(value)) value = std::numeric_limits<double>::quiet_NaN();
  if (!source.in_si) scale(values, unit.factor(), unit.offset());
}

/// Of samples `first` to `last`; channels with the same series share them.
Timeline times_of(const Source& source, const Timeline& even, std::size_t first, std::size_t last,
                  std::map<const Series*, Stamps>& shared) {
  if (!source.stamps) return {even.time(first), even.rate, nullptr};
  Stamps& known = shared[source.stamps.get()];
  if (!known) {
    std::vector<double> stamps;
    source.stamps->read(first, last - first, stamps);
    scale(stamps, source.second, source.begin);
    known = std::make_shared<const std::vector<double>>(std::move(stamps));
  }
  return {0.0, 0.0, known};
}

}  // namespace

Recording in_memory(Gathered gathered) {
  std::map<const Series*, Stamps> shared;
  for (std::size_t i = 0; i < gathered.sources.size(); ++i) {
    const Source& source = gathered.sources[i];
    Channel& channel = gathered.frame.channels[i];
    channel.timeline = times_of(source, channel.timeline, 0, source.values->size(), shared);
    const bool infinite = source.values->infinite() > 0;
    channel.values = source.values->take();
    make_si(source, infinite, channel.unit, channel.values);
  }
  return std::move(gathered.frame);
}

void hand_out(const Gathered& gathered, std::size_t samples, const BlockSink& sink, const Progress& progress) {
  Recording block = gathered.frame;
  std::size_t longest = 0;
  for (const Source& source : gathered.sources) longest = std::max(longest, source.values->size());
  const Shares shares(longest, samples);
  for (std::size_t index = 0; index < shares.blocks(); ++index) {
    report(progress, static_cast<double>(index) / static_cast<double>(shares.blocks()), "reading");
    std::map<const Series*, Stamps> shared;
    for (std::size_t i = 0; i < gathered.sources.size(); ++i) {
      const Source& source = gathered.sources[i];
      const std::size_t count = source.values->size();
      const std::size_t first = shares.first(count, index), last = shares.first(count, index + 1);
      Channel& channel = block.channels[i];
      channel.timeline = times_of(source, gathered.frame.channels[i].timeline, first, last, shared);
      channel.values.clear();
      source.values->read(first, last - first, channel.values);
      make_si(source, source.values->infinite() > 0, channel.unit, channel.values);
    }
    sink(block);
    block.findings.clear();
  }
}

}  // namespace tumble::file
