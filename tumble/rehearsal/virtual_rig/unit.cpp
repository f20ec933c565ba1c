#include "tumble/rehearsal/virtual_rig/unit.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/step_means.hpp"

namespace tumble::virtual_rig {
namespace {

constexpr std::size_t unknown = static_cast<std::size_t>(-1);
constexpr std::size_t sensor_portion = 8192;           ///< as sensors_of() in sim/
constexpr std::size_t endless = std::size_t{1} << 40;  ///< samples, of a power-up whose end is not known

/// The reference as seen by instruments that were switched on at `offset`.
Reference shifted(const Reference& course, double offset) {
  Reference own;
  Felt at_begin;
  course.felt(offset, 1.0, std::span(&at_begin, 1));
  own.felt = [felt = course.felt, offset, start = at_begin.temperature](double first, double step,
                                                                        std::span<Felt> out) {
    felt(first + offset, step, out);
    for (Felt& one : out) {
      one.since_power_on -= offset;
      one.start_temperature = start;
    }
  };
  if (course.steady_until)
    own.steady_until = [steady = course.steady_until, offset](double time) { return steady(time + offset) - offset; };
  for (const auto& sensor : course.sensors)
    own.sensors.push_back(
        {sensor.channel, [read = sensor.read, offset](double first, double step, std::span<double> out) {
           read(first + offset, step, out);
         }});
  return own;
}

/// What remains of a schedule after `offset`.
Schedule remaining(const Schedule& segments, double offset) {
  Schedule out;
  double begin = 0.0;
  for (const auto& segment : segments) {
    const double end = begin + segment.duration;
    if (end > offset) {
      out.push_back(segment);
      out.back().duration = end - std::max(begin, offset);
    }
    begin = end;
  }
  return out;
}

std::vector<std::span<double>> room_in(std::vector<std::vector<double>>& values, std::size_t channels,
                                       std::size_t size) {
  values.resize(channels);
  std::vector<std::span<double>> out;
  for (auto& channel : values) {
    channel.resize(size);
    out.emplace_back(channel);
  }
  return out;
}

}  // namespace

Unit::Unit(std::shared_ptr<const Plan> plan, const RandomStream& random, const PlannedRun& run, int power_up,
           double offset)
    : plan_(std::move(plan)),
      begin_(run.begin),
      offset_(offset),
      rate_(plan_->sample_rate),
      steps_per_sample_(oversampling_of(*plan_)),
      power_up_(power_up),
      before_(*plan_, run, random),
      after_(before_),
      channels_(before_.channels()) {}

void Unit::end(double time) {
  total_ = std::max(given_, static_cast<std::size_t>(std::max(0LL, std::llround((time - begin_) * rate_))));
  outputs_.version = unknown;  // the last steps are made without a look at what would have followed
}

std::size_t Unit::known(double time, SampleTiming timing) const {
  if (total_) return *total_;
  double samples = (time - begin_) * rate_;
  if (timing == SampleTiming::final) samples -= static_cast<double>(step_margin + 1) / steps_per_sample_;
  return samples <= 0.0 ? 0 : static_cast<std::size_t>(std::floor(samples * (1.0 + 1e-15) + 1e-9));
}

std::size_t Unit::size_from(std::size_t first, std::size_t portion) const {
  return total_ ? std::min(portion, *total_ - first) : portion;
}

const Reference& Unit::reference(Course& course, std::size_t until) {
  const double margin = static_cast<double>(step_margin + 1) / (rate_ * steps_per_sample_);
  const Reference& whole = course.reference(offset_ + static_cast<double>(until) / rate_ + margin);
  if (offset_ == 0.0) return whole;
  shifted_ = shifted(whole, offset_);
  return shifted_;
}

void Unit::make_outputs(Course& course) {
  const std::size_t portion = before_.portion(), first = given_ / portion * portion, size = size_from(first, portion);
  if (outputs_.covers(given_) && outputs_.version == course.version() && outputs_.size == size) return;
  if (outputs_.size > 0 && outputs_.first != first) before_ = after_;
  after_ = before_;
  after_.follow(reference(course, first + size),
                offset_ == 0.0 ? course.segments() : remaining(course.segments(), offset_), total_.value_or(endless));
  after_.make(first, room_in(outputs_.values, before_.channels().size(), size));
  outputs_.first = first;
  outputs_.size = size;
  outputs_.version = course.version();
}

void Unit::make_sensors(Course& course) {
  const std::size_t first = given_ / sensor_portion * sensor_portion, size = size_from(first, sensor_portion);
  if (sensors_.covers(given_) && sensors_.version == course.version() && sensors_.size == size) return;
  const Reference& rig = reference(course, first + size);
  if (channels_.size() < before_.channels().size() + rig.sensors.size())
    for (const auto& sensor : rig.sensors) channels_.push_back(sensor.channel);
  const auto room = room_in(sensors_.values, rig.sensors.size(), size);
  const double step = 1.0 / rate_;
  for (std::size_t s = 0; s < rig.sensors.size(); ++s)
    rig.sensors[s].read((static_cast<double>(first) + 0.5) * step, step, room[s]);
  sensors_.first = first;
  sensors_.size = size;
  sensors_.version = course.version();
}

VirtualSamples Unit::take(Course& course, std::size_t until) {
  VirtualSamples out{power_up_, given_, {}};
  if (total_) until = std::min(until, *total_);
  if (until <= given_) return out;
  const std::size_t count = until - given_, first = given_;
  std::vector<std::vector<double>> values;
  while (given_ < until) {
    make_outputs(course);
    make_sensors(course);
    values.resize(outputs_.values.size() + sensors_.values.size());
    const std::size_t end = std::min({until, outputs_.first + outputs_.size, sensors_.first + sensors_.size});
    std::size_t c = 0;
    for (const Portion* portion : {&outputs_, &sensors_})
      for (const auto& channel : portion->values) {
        const auto from = channel.begin() + static_cast<std::ptrdiff_t>(given_ - portion->first);
        values[c].reserve(count);
        values[c].insert(values[c].end(), from, from + static_cast<std::ptrdiff_t>(end - given_));
        ++c;
      }
    given_ = end;
  }
  out.channels = channels_;
  for (std::size_t c = 0; c < values.size(); ++c) {
    out.channels[c].values = std::move(values[c]);
    out.channels[c].timeline = {begin_ + static_cast<double>(first) / rate_, rate_, nullptr};
  }
  return out;
}

}  // namespace tumble::virtual_rig
