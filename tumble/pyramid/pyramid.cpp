#include "tumble/pyramid/pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "tumble/pyramid/store/live_track.hpp"
#include "tumble/pyramid/store/mapped.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

using store::Json, store::Mapped, store::MappedChannel, store::MappedLevel;

struct Pyramid::Parts {
  std::optional<Mapped> file;
  std::vector<std::shared_ptr<const void>> owners;
  SampleReader reader;
  Recording header;
  std::vector<PyramidChannel> channels;
  std::vector<MappedChannel> mapped_channels;
};

Pyramid::Pyramid(const std::string& path, SampleReader samples) : parts_(std::make_unique<Parts>()) {
  Parts& parts = *parts_;
  parts.file.emplace(path);
  parts.reader = std::move(samples);
  try {
    const Json description = store::description_in(*parts.file);
    parts.header = store::recording_of(description);
    for (const Json& entry : description.at("channels")) {
      const Channel& channel = parts.header.channels[parts.channels.size()];
      parts.channels.push_back({channel.name, channel.kind, channel.unit, entry.at("count").get<std::size_t>(),
                                entry.at("first").get<double>(), entry.at("last").get<double>(),
                                entry.at("stamped").get<bool>()});
      parts.mapped_channels.push_back(store::mapped(*parts.file, entry));
    }
    for (const MappedChannel& channel : parts.mapped_channels)
      if (channel.clock >= parts.channels.size() || (channel.samples.empty() && !parts.reader && channel.count > 0))
        Mapped::damaged();
  } catch (const Json::exception&) {
    Mapped::damaged();
  }
}

Pyramid::Pyramid(PyramidMoment moment) : parts_(std::make_unique<Parts>()) {
  auto live = std::any_cast<store::LiveChannels>(std::move(moment.store));
  parts_->owners = std::move(live.owners);
  parts_->mapped_channels = std::move(live.channels);
  parts_->header = std::move(moment.header);
  parts_->channels = std::move(moment.channels);
}

Pyramid::Pyramid(Pyramid&&) noexcept = default;
Pyramid& Pyramid::operator=(Pyramid&&) noexcept = default;
Pyramid::~Pyramid() = default;

const Recording& Pyramid::header() const { return parts_->header; }
const std::vector<PyramidChannel>& Pyramid::channels() const { return parts_->channels; }

double Pyramid::time(std::size_t channel, std::size_t sample) const {
  const MappedChannel& of = parts_->mapped_channels[channel];
  if (of.track) return of.track->time(sample);
  if (parts_->channels[channel].stamped) return parts_->mapped_channels[of.clock].stamps.at(sample);
  return of.start + static_cast<double>(sample) / of.rate;
}

std::size_t Pyramid::index_at(std::size_t channel, double time_wanted) const {
  if (const auto& track = parts_->mapped_channels[channel].track) return track->index_at(time_wanted);
  std::size_t low = 0, high = parts_->channels[channel].samples;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (time(channel, middle) < time_wanted)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

void Pyramid::read(std::size_t channel, std::size_t first, std::size_t count, std::vector<double>& to) const {
  const MappedChannel& of = parts_->mapped_channels[channel];
  first = std::min(first, of.count);
  count = std::min(count, of.count - first);
  if (count == 0) return;
  if (of.track)
    of.track->read(first, count, to);
  else if (of.samples.empty())
    parts_->reader(channel, first, count, to);
  else
    of.samples.append(first, count, to);
}

namespace {

/// What one view is made of: samples first .. end - 1 of a channel, as bars of `block` samples each.
struct Stretch {
  std::size_t first = 0, end = 0, block = 1;
};

Stretch stretch_of(std::size_t first, std::size_t end, std::size_t count, std::size_t pixels) {
  pixels = std::max<std::size_t>(pixels, 1);
  const std::size_t samples = end - first;
  if (samples <= 2 * pixels) return {first, end, 1};
  std::size_t unit_block = 1;  // the coarsest level whose blocks are not wider than a pixel
  for (std::size_t size = store::finest; size <= samples / pixels; size *= store::factor) unit_block = size;
  const std::size_t merged = (samples + pixels * unit_block - 1) / (pixels * unit_block);
  const std::size_t block = merged * unit_block;
  return {first / block * block, std::min((end + block - 1) / block * block, count), block};
}

/// Bounds of a bar [SI], before they are rounded to what is sent.
struct Bar {
  double low = std::nan(""), high = std::nan("");
  std::uint8_t flags = 0;
};

Bar bar_of_samples(const double* values, std::size_t count) {
  Bar bar;
  std::size_t present = 0;
  for (std::size_t i = 0; i < count; ++i) {
    present += !std::isnan(values[i]);
    bar.low = std::fmin(bar.low, values[i]);
    bar.high = std::fmax(bar.high, values[i]);
  }
  if (present < count) bar.flags |= ChannelView::missing;
  if (present > 1 && bar.low == bar.high) bar.flags |= ChannelView::constant;
  return bar;
}

Bar bar_of_blocks(const MappedLevel& level, double offset, std::size_t first, std::size_t end) {
  Bar bar;
  std::uint8_t constant = ChannelView::constant, missing = 0;
  float low = std::nanf(""), high = low;
  for (std::size_t i = first; i < std::min(end, level.count); ++i) {
    if (level.low[i] != level.low[first] || level.high[i] != level.high[first]) constant = 0;
    low = std::fmin(low, level.low[i]);
    high = std::fmax(high, level.high[i]);
    constant &= level.flags[i];
    missing = static_cast<std::uint8_t>(missing | (level.flags[i] & ChannelView::missing));
  }
  bar.low = offset + static_cast<double>(low);
  bar.high = offset + static_cast<double>(high);
  bar.flags = constant | missing;
  return bar;
}

/// In the unit of the view, as floats about its offset, rounded outward. Another unit keeps the order of values but
/// rounds them once more.
void add_bar(const Bar& bar, const Unit& unit, ChannelView& view) {
  const bool none = std::isnan(bar.low);
  view.low.push_back(none ? std::nanf("") : store::rounded_down(unit.from_si(bar.low), view.offset));
  view.high.push_back(none ? std::nanf("") : store::rounded_up(unit.from_si(bar.high), view.offset));
  view.flags.push_back(bar.flags);
}

}  // namespace

ChannelView Pyramid::view(std::size_t channel, double from, double to, std::size_t pixels, const Unit& unit) const {
  const MappedChannel& of = parts_->mapped_channels[channel];
  const bool stamped = parts_->channels[channel].stamped;
  const std::size_t begin = index_at(channel, from), end = index_at(channel, to);
  const Stretch stretch = stretch_of(begin - (begin > 0), std::min(end + 1, of.count), of.count, pixels);
  ChannelView view;
  view.samples = stretch.block == 1;
  view.first = stretch.first;
  view.block = stretch.block;
  view.offset = of.count > 0 ? unit.from_si(of.offset) : 0.0;
  if (stretch.first < of.count) view.start = time(channel, stretch.first);
  if (!stamped) view.step = static_cast<double>(stretch.block) / of.rate;
  std::vector<double> values;
  if (of.track && stretch.block < store::finest) {
    of.track->read_times(stretch.first, stretch.end - stretch.first, values);
    for (std::size_t i = 0; i < values.size(); i += stretch.block) view.times.push_back(values[i]);
    values.clear();
  } else {
    for (std::size_t i = stretch.first; stamped && i < stretch.end; i += stretch.block)
      view.times.push_back(time(channel, i));
  }
  if (stretch.block < store::finest) read(channel, stretch.first, stretch.end - stretch.first, values);
  if (view.samples) {
    for (double& value : values) value = unit.from_si(value);
    view.values = std::move(values);
    return view;
  }
  std::size_t level = 0, size = store::finest;
  while (size * store::factor <= stretch.block && level + 1 < of.levels.size()) size *= store::factor, ++level;
  for (std::size_t first = stretch.first; first < stretch.end; first += stretch.block) {
    const std::size_t last = std::min(first + stretch.block, stretch.end);
    add_bar(stretch.block < store::finest
                ? bar_of_samples(values.data() + (first - stretch.first), last - first)
                : bar_of_blocks(of.levels[level], of.offset, first / size, (last + size - 1) / size),
            unit, view);
  }
  return view;
}

namespace {

/// What moments of samples, about an offset [SI], say of them; the slope in [SI/s] for time that passes at this rate
/// [1/s].
void describe(const Moments& all, double offset, double rate, SpanStatistics& result) {
  const double none = std::nan("");
  result.missing = result.samples - static_cast<std::size_t>(all.count);
  result.mean = all.count > 0.0 ? offset + all.mean : none;
  result.sd = all.count > 1.0 ? std::sqrt(all.squares / (all.count - 1.0)) : none;
  result.minimum = all.count > 0.0 ? all.minimum : none;
  result.maximum = all.count > 0.0 ? all.maximum : none;
  result.slope = all.squares_time > 0.0 ? all.products / all.squares_time * rate : none;
}

}  // namespace

SpanStatistics Pyramid::statistics(std::size_t channel, std::size_t first, std::size_t end) const {
  const MappedChannel& of = parts_->mapped_channels[channel];
  const PyramidChannel& face = parts_->channels[channel];
  end = std::min(end, of.count);
  first = std::min(first, end);
  SpanStatistics result;
  result.samples = end - first;
  if (first == end) return result;
  result.first = time(channel, first);
  result.last = time(channel, end - 1);

  Moments all;
  std::vector<double> values, times;
  const auto add_samples = [&](std::size_t from, std::size_t to) {
    if (from >= to) return;
    values.clear();
    times.clear();
    read(channel, from, to - from, values);
    if (of.track)
      of.track->read_times(from, to - from, times);
    else if (face.stamped)
      parts_->mapped_channels[of.clock].stamps.append(from, to - from, times);
    all = joined(all, moments_of(values.data(), face.stamped ? times.data() : nullptr, values.size(),
                                 face.stamped ? times.front() : static_cast<double>(from), of.offset));
  };
  // Samples up to the first block, blocks of growing and then of falling size, samples behind the last block.
  std::size_t place = std::min(end, (first + store::moment_block - 1) / store::moment_block * store::moment_block);
  add_samples(first, place);
  while (place + store::moment_block <= end) {
    std::size_t level = 0, size = store::moment_block;
    while (level + 1 < of.moments.size() && place % (size * store::factor) == 0 && place + size * store::factor <= end)
      size *= store::factor, ++level;
    all = joined(all, of.moments[level].blocks[place / size]);
    place += size;
  }
  add_samples(place, end);
  describe(all, of.offset, face.stamped ? 1.0 : of.rate, result);
  return result;
}

}  // namespace tumble
