#include "tumble/station/conduct/flood_watch.hpp"

#include <algorithm>
#include <utility>

namespace tumble::conduct {
namespace {

constexpr double unasked_rate = 65536.0;           ///< [byte/s] of a controller
constexpr double other_questions = 4.0;            ///< of a poll, beside one for each axis: state, alarm, set point
constexpr double stream_rate = 262144.0;           ///< [byte/s] beside what is declared
constexpr double undeclared_rate = 16777216.0;     ///< [byte/s]
constexpr double times_declared = 10.0;            ///< [1]
constexpr double longest_line = 1024.0;            ///< [byte] of a frame that is a line of text
constexpr double flood_after = 1.0;                ///< [s] of what is explained
constexpr std::size_t latest_of_flood = 2048;      ///< [byte]
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
  return unasked_rate + questions * static_cast<double>(controller.longest) / std::max(station.devices[device].poll, 1e-3);
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
