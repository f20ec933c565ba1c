#include "tumble/methods/imu_multi_position/data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tumble/clocks/clock.hpp"
#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/extremes.hpp"
#include "tumble/math/median.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_multi_position {
namespace {

constexpr std::size_t fewest = 64;       ///< samples of a channel
constexpr std::size_t longest_loss = 3;  ///< samples lost in a row that are interpolated: no hand turns back meanwhile

struct Kind {
  const char* name;
  QuantityKind quantity, increment;
  const char* units;
};
constexpr Kind accelerometers{"accelerometer", QuantityKind::specific_force, QuantityKind::velocity,
                              "specific force (m/s^2, g), velocity increments or LSB"};
constexpr Kind gyros{"gyro", QuantityKind::angular_rate, QuantityKind::angle,
                     "angular rate (rad/s, deg/s), angle increments or LSB"};

std::string label(const Evidence& evidence, std::size_t r) {
  if (evidence.recordings.size() < 2) return "";
  const auto& file = evidence.recordings[r].origin.file;
  return file.empty() ? fmt::format("recording {}", r + 1) : file;
}

/// The three channels, or what hinders; none at all: null and no problem.
std::array<const Channel*, 3> channels_of(const Evidence& evidence, std::size_t r, const Kind& kind,
                                          Problems& problems) {
  std::array<const Channel*, 3> channels{};
  std::string missing;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string role = fmt::format("{}_{}", kind.name, letters[i]);
    channels[i] = channel_for(evidence, evidence.recordings[r], role);
    if (channels[i] == nullptr) missing += (missing.empty() ? "" : ", ") + role;
  }
  if (missing.empty()) return channels;
  const std::size_t present = 3 - static_cast<std::size_t>(std::ranges::count(channels, nullptr));
  if (present > 0)
    problems.push_back(
        in_file(label(evidence, r), say("no channel for {}: all three of a triad are needed", Name{missing})));
  return {};
}

void check(const std::array<const Channel*, 3>& channels, const Kind& kind, Problems& problems) {
  for (const Channel* c : channels) {
    if (c->kind != kind.quantity && c->kind != kind.increment && c->kind != QuantityKind::count)
      problems.push_back(say("channel '{}' [{}] is {}; {} takes {}", c->name, Name{c->unit.text()},
                             Sentence(std::string(name(c->kind)).c_str()), kind.name, kind.units));
    else if (c->kind != channels[0]->kind)
      problems.push_back(say("channels '{}' [{}] and '{}' [{}] differ in kind", channels[0]->name,
                             Name{channels[0]->unit.text()}, c->name, Name{c->unit.text()}));
    if (c->values.size() < fewest)
      problems.push_back(say("channel '{}' has {}", c->name, said_count(c->values.size(), "sample")));
    else if (c->values.size() != channels[0]->values.size())
      problems.push_back(say("channels '{}' and '{}' differ in length", channels[0]->name, c->name));
  }
}

/// A dead accelerometer would make the method ask for more rests without end.
void check_alive(const std::array<const Channel*, 3>& channels, Problems& problems) {
  for (const Channel* c : channels) {
    const Extremes extremes = extremes_of(c->values);
    if (extremes.lowest == extremes.highest)
      problems.push_back(say("channel '{}' holds the same value throughout", c->name));
  }
}

/// Longest run of samples in a row with this value.
std::size_t longest_run(const std::vector<double>& values, double of) {
  std::size_t run = 0, longest = 0;
  for (const double v : values) run = v == of ? run + 1 : 0, longest = std::max(longest, run);
  return longest;
}

/// An output that stays at its greatest or least value for three samples and more, far from its median.
void find_range(Triad& triad, std::size_t axis) {
  std::vector<double> values;
  for (const auto& v : triad.value)
    if (std::isfinite(v[axis])) values.push_back(v[axis]);
  if (values.empty()) return;
  const auto [lowest, highest] = std::ranges::minmax(values);
  const double middle = median(values), far = 0.25 * (highest - lowest);
  if (middle - lowest > far && longest_run(values, lowest) >= 3) triad.lowest[axis] = lowest;
  if (highest - middle > far && longest_run(values, highest) >= 3) triad.highest[axis] = highest;
}

/// Puts samples into gaps of the stamps that are no longer than the longest loss: still missing.
void open_gaps(Triad& triad) {
  Triad out = triad;
  out.time.clear(), out.value.clear(), out.gaps.clear();
  const Vector3 nothing{std::nan(""), std::nan(""), std::nan("")};
  std::size_t next = 0;
  for (std::size_t i = 0; i < triad.time.size(); ++i) {
    out.time.push_back(triad.time[i]), out.value.push_back(triad.value[i]);
    if (next == triad.gaps.size() || triad.gaps[next] != i || i + 1 == triad.time.size()) continue;
    ++next;
    const double length = triad.time[i + 1] - triad.time[i];
    const auto lost = static_cast<std::size_t>(std::max(0LL, std::llround(length / triad.step) - 1));
    if (lost > longest_loss) out.gaps.push_back(out.time.size() - 1);
    for (std::size_t k = 1; k <= lost && lost <= longest_loss; ++k) {
      out.time.push_back(triad.time[i] + length * static_cast<double>(k) / static_cast<double>(lost + 1));
      out.value.push_back(nothing);
    }
  }
  triad = std::move(out);
}

/// Interpolates samples that are lost one by one, axis by axis. A mean over a rest takes no harm, and the turn of a
/// move by half of the change of the rate over a sample at most.
void fill_losses(Triad& triad) {
  const std::size_t n = triad.value.size();
  triad.filled.assign(n, 0);
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t i = 1; i < n; ++i) {
      if (std::isfinite(triad.value[i][a]) || !std::isfinite(triad.value[i - 1][a])) continue;
      std::size_t end = i;
      while (end < n && !std::isfinite(triad.value[end][a])) ++end;
      const std::size_t lost = end - i;
      if (end == n || lost > longest_loss) continue;
      const double before = triad.value[i - 1][a],
                   step = (triad.value[end][a] - before) / static_cast<double>(lost + 1);
      for (std::size_t k = 0; k < lost; ++k) {
        triad.value[i + k][a] = before + static_cast<double>(k + 1) * step;
        triad.filled[i + k] = 1;
      }
    }
}

Triad triad_of(const std::array<const Channel*, 3>& channels, const Kind& kind, Problems& problems) {
  Triad triad;
  const Channel& first = *channels[0];
  const Clock clock = clock_of(first);
  if (clock.backward > 0)
    problems.push_back(
        say("channel '{}': the stamps run backwards at sample {}", first.name, clock.first_backward + 1));
  if (!(clock.rate > 0.0)) {
    problems.push_back(say("channel '{}': its stamps do not show a sampling rate", first.name));
    return triad;
  }
  triad.step = 1.0 / clock.rate;
  const double scale = first.kind == kind.increment ? clock.rate : 1.0;
  triad.counts = first.kind == QuantityKind::count;
  const std::size_t n = first.values.size();
  triad.time.resize(n), triad.value.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    triad.time[i] = clock.even ? first.time(0) + static_cast<double>(i) * triad.step : first.time(i);
    for (std::size_t a = 0; a < 3; ++a) triad.value[i][a] = scale * channels[a]->values[i];
  }
  for (const auto& gap : clock.gaps) triad.gaps.push_back(gap.after);
  open_gaps(triad);
  fill_losses(triad);
  for (std::size_t a = 0; a < 3; ++a) {
    triad.names[a] = channels[a]->name;
    if (kind.quantity == QuantityKind::angular_rate) find_range(triad, a);
  }
  return triad;
}

/// Empty where the recording has none of that kind.
Triad triad_in(const Evidence& evidence, std::size_t r, const Kind& kind, Problems& problems) {
  const auto before = problems.size();
  const auto channels = channels_of(evidence, r, kind, problems);
  if (channels[0] == nullptr || problems.size() > before) return {};
  check(channels, kind, problems);
  if (kind.quantity == QuantityKind::specific_force) check_alive(channels, problems);
  return problems.size() > before ? Triad{} : triad_of(channels, kind, problems);
}

}  // namespace

std::size_t Triad::index(double instant) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(time, instant - stamp_slack(instant, step)) - time.begin());
}

bool Triad::clipped(std::size_t sample) const {
  for (std::size_t a = 0; a < 3; ++a)
    if (value[sample][a] <= lowest[a] || value[sample][a] >= highest[a]) return true;
  return false;
}

std::vector<Session> sessions_of(const Evidence& evidence) {
  Problems problems;
  std::vector<Session> sessions;
  std::vector<Triad> gyros_alone;
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    Triad forces = triad_in(evidence, r, accelerometers, problems), rates = triad_in(evidence, r, gyros, problems);
    if (!forces.empty())
      sessions.push_back({label(evidence, r), std::move(forces), std::move(rates)});
    else if (!rates.empty())
      gyros_alone.push_back(std::move(rates));
  }
  for (auto& session : sessions)
    if (session.gyro.empty() && !gyros_alone.empty())
      session.gyro = std::move(gyros_alone.front()), gyros_alone.erase(gyros_alone.begin());
  if (sessions.empty() && problems.empty())
    problems.push_back(
        "there are no accelerometers: channels accelerometer_x, _y, _z are needed, and gyro_x, _y, _z beside them");
  for (const auto& session : sessions)
    if (session.accelerometer.counts != sessions[0].accelerometer.counts ||
        (!session.gyro.empty() && !sessions[0].gyro.empty() && session.gyro.counts != sessions[0].gyro.counts))
      problems.push_back(say("{}: recordings of one test must be in the same kind of unit", Name{session.where}));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, std::move(problems));
  return sessions;
}

}  // namespace tumble::imu_multi_position
