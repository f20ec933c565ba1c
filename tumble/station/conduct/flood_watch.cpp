#include "tumble/station/conduct/flood_watch.hpp"

#include <algorithm>
#include <utility>

namespace tumble::conduct {
namespace {

constexpr double unasked_rate = 65536.0;        ///< [byte/s] of a controller
constexpr double other_questions = 4.0;         ///< of a poll, beside one for each axis: state, alarm, set point
constexpr double stream_rate = 262144.0;        ///< [byte/s] beside what is declared
constexpr double undeclared_rate = 16777216.0;  ///< [byte/s]
constexpr double times_declared = 10.0;         ///< [1]
constexpr double longest_line = 1024.0;         ///< [byte] of a frame that is a line of text
constexpr double flood_after = 1.0;             ///< [s] of what is explained
constexpr std::size_t latest_of_flood = 2048;   ///< [byte]
constexpr int words_in_second = 20;

double longest_of(const FrameLayout& layout) {
  if (layout.text) return longest_line;
  const bool varies = layout.length_number || !layout.masks.empty() || layout.list;
  return varies ? std::max(layout.length, layout.longest) : layout.length;
}

}  // namespace

double explained_rate(const Station& station, std::size_t device, const Controller& controller) {
  const auto axes = std::ranges::count(station.axes, device, &StationAxis::device);
  const double questions = static_cast<double>(axes) + other_questions;
  return unasked_rate +
         questions * static_cast<double>(controller.longest) / std::max(station.devices[device].poll, 1e-3);
}

double explained_rate(const StationInstrument& instrument, const FrameCodec& codec) {
  const double rate = std::max(instrument.rate, codec.rate);
  if (!(rate > 0.0)) return undeclared_rate;
  double frame = 0.0;  // several kinds may belong to one sample
  for (const FrameLayout& layout : codec.frames) frame += longest_of(layout);
  return stream_rate + times_declared * rate * frame;
}

std::string_view FloodWatch::take(std::string_view bytes, double time) {
  const double room = flood_after * rate_;
  if (begun_ && level_ > 0.0) level_ = std::max(0.0, level_ - rate_ * std::max(0.0, time - time_));
  begun_ = true;
  time_ = std::max(time_, time);
  level_ += static_cast<double>(bytes.size());
  if (level_ <= room) return bytes;
  floods_ = true;
  level_ = std::min(level_, 2.0 * room);
  const std::string_view latest = bytes.substr(bytes.size() - std::min(bytes.size(), latest_of_flood));
  dropped_ += bytes.size() - latest.size();
  return latest;
}

Floods::Floods(const Station& station, const StationParts& parts, double longest_look) : longest_look_(longest_look) {
  for (std::size_t d = 0; d < station.devices.size(); ++d) {
    wires_.emplace_back(explained_rate(station, d, parts.controllers[d]));
    names_.push_back(station.devices[d].name);
  }
  for (std::size_t i = 0; i < station.instruments.size(); ++i) {
    wires_.emplace_back(explained_rate(station.instruments[i], parts.streams[i].codec));
    names_.push_back(station.instruments[i].slot);
  }
}

std::string_view Floods::take(const LinkEvent& event, const std::function<void(const Sentence&)>& stop) {
  FloodWatch& wire = wires_[event.link];
  const bool known = wire.floods();
  const std::string_view taken = wire.take(event.bytes, event.time);
  if (wire.floods() && !known)
    stop(say("{} floods its link: more than {:.0f} kB/s arrive, which nothing that it was asked for explains",
             Name{names_[event.link]}, 1e-3 * wire.rate()));
  return taken;
}

void Floods::looked(double now) {
  if (begun_ && now - looked_ > 2.0 * longest_look_)
    for (FloodWatch& wire : wires_) wire.overslept(now - looked_);
  begun_ = true;
  looked_ = now;
}

std::vector<Sentence> Floods::dropped() const {
  std::vector<Sentence> words;
  for (std::size_t wire = 0; wire < wires_.size(); ++wire)
    if (wires_[wire].dropped() > 0)
      words.push_back(say("{}: {} bytes of the flood are not kept", Name{names_[wire]}, wires_[wire].dropped()));
  return words;
}

bool WordLimit::allows(double time) {
  if (time - second_ >= 1.0 || time < second_) second_ = time, count_ = 0;
  if (++count_ <= words_in_second) return true;
  ++untold_;
  return false;
}

std::uint64_t WordLimit::take_untold(double time) {
  return untold_ > 0 && time - second_ >= 1.0 ? std::exchange(untold_, 0) : 0;
}

}  // namespace tumble::conduct
