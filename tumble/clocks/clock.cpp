#include "tumble/clocks/clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "tumble/clocks/ticks.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/median.hpp"

namespace tumble {

namespace {

using Stamps = std::vector<double>;

/// Whether long intervals are those between the readings of a buffer, whose samples are stamped as they are read out:
/// most of them are alike, and the stretches between them take next to no time.
bool reads_a_buffer(std::vector<double> pauses, double all) {
  constexpr std::size_t few = 8;
  constexpr double alike = 0.25, reading = 0.1;
  if (pauses.size() < few) return false;
  double paused = 0.0;
  for (const double pause : pauses) paused += pause;
  const double middle = median(pauses);
  const auto near = std::ranges::count_if(pauses, [&](double p) { return std::abs(p - middle) <= alike * middle; });
  return 2 * static_cast<std::size_t>(near) > pauses.size() && all - paused < reading * all;
}

/// Up to 10 000 intervals between neighbours, in pieces that are spread over the record: every second one of the whole record
/// would miss the pauses of a buffer that is read after every eight samples.
std::vector<double> some_intervals(const Stamps& t) {
  constexpr std::size_t pieces = 100, of_each = 100;
  const std::size_t all = t.size() - 1;
  std::vector<double> intervals;
  const auto add = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) intervals.push_back(t[i + 1] - t[i]);
  };
  if (all <= pieces * of_each) {
    add(0, all);
  } else {
    for (std::size_t k = 0; k < pieces; ++k) {
      const std::size_t begin = k * (all - of_each) / (pieces - 1);
      add(begin, begin + of_each);
    }
  }
  return intervals;
}

/// The interval that most of the neighbours keep to for most of the time, from up to 10 000 of them spread over the
/// record; 0 when they do not keep to one. Samples that are lost one by one leave a few of its multiples; in a burst
/// the common interval takes little of the time.
double common_interval(const Stamps& t) {
  constexpr double scatter = 0.25, most_multiple = 4.0, longest = 10.0;
  const std::vector<double> intervals = some_intervals(t);
  std::vector<double> pauses;
  const double middle = median(intervals);
  double near = 0.0, multiples = 0.0, all = 0.0, time = 0.0;
  std::size_t count = 0;
  for (const double interval : intervals) {
    const double times = std::clamp(std::round(interval / middle), 1.0, most_multiple);
    const bool fits = std::abs(interval - times * middle) <= scatter * middle;
    const bool is_near = fits && times == 1.0;
    near += is_near ? interval : 0.0;
    count += is_near;
    multiples += fits ? interval : 0.0;
    all += std::min(interval, longest * middle);  // one long gap is no argument
    time += interval;
    if (interval > longest * middle) pauses.push_back(interval);
  }
  const bool common = 10 * count >= 6 * intervals.size() && 2.0 * multiples > all;
  return common && !reads_a_buffer(std::move(pauses), time) ? near / static_cast<double>(count) : 0.0;
}

/// The common interval more exactly: the mean over windows that last whole multiples of it, within a quarter. Each time
/// the windows are longer; a sample that is lost or written twice leaves a multiple. 0 where windows of 8 samples do
/// not last multiples.
double refined(const Stamps& t, double interval) {
  constexpr double off = 0.25, most_lost = 4.0;
  double result = 0.0;
  for (std::size_t lag = 8; lag <= 512 && 16 * lag <= t.size(); lag *= 8) {
    double sum = 0.0, multiples = 0.0;
    std::size_t windows = 0, fitting = 0;
    for (std::size_t i = 0; i + lag < t.size(); i += lag, ++windows) {
      const double length = t[i + lag] - t[i], times = std::round(length / interval);
      if (std::abs(length / interval - times) > off || times > most_lost * static_cast<double>(lag)) continue;
      sum += length, multiples += times;
      ++fitting;
    }
    if (4 * fitting < 3 * windows || !(multiples > 0.0)) return result;
    result = interval = sum / multiples;
  }
  return result;
}

/// The interval of the clock behind the stamps.
struct Period {
  double interval = 0.0;
  bool regular = false;  ///< most neighbours keep to it
};

/// Where most neighbours keep to one interval it is that; else the samples come in bursts, and only means over many
/// tell it.
Period period(const Stamps& t) {
  const std::size_t intervals = t.size() - 1, parts = std::clamp<std::size_t>(intervals / 8, 1, 64);
  const double common = common_interval(t);
  if (const double exact = common > 0.0 ? refined(t, common) : 0.0; exact > 0.0) return {exact, true};
  std::vector<double> means;
  for (std::size_t k = 0; k < parts; ++k) {
    const std::size_t a = k * intervals / parts, b = (k + 1) * intervals / parts;
    means.push_back((t[b] - t[a]) / static_cast<double>(b - a));
  }
  const double mean = median(means);
  const bool regular = common > 0.0;
  return {regular && std::abs(mean - common) > 0.01 * common ? common : mean, regular};
}

/// For each sample how many before it were written twice, with the stamp of the sample before; empty: none is taken for
/// that.
using Repeats = std::vector<std::size_t>;

/// Whether samples that have the stamp of the one before have its value too, and others do not: rows written twice. A
/// timer coarser than the interval gives such stamps to samples that differ.
bool written_twice(const Channel& channel) {
  const Stamps& t = *channel.timeline.stamps;
  const auto& v = channel.values;
  std::size_t repeats = 0, alike = 0, others_alike = 0;
  for (std::size_t i = 1; i < std::min(t.size(), v.size()); ++i) {
    const bool same = v[i] == v[i - 1];
    if (t[i] == t[i - 1])
      ++repeats, alike += same;
    else
      others_alike += same;
  }
  return repeats > 0 && 20 * alike >= 19 * repeats && 2 * others_alike < v.size();
}

Repeats repeats_in(const Stamps& t) {
  Repeats repeats(t.size(), 0);
  for (std::size_t i = 1; i < t.size(); ++i) repeats[i] = repeats[i - 1] + (t[i] == t[i - 1]);
  return repeats;
}

/// The departure from even spacing, r_i = t_i - t_0 - i T, and its least value over a stretch.
struct Departure {
  const Stamps& t;
  double interval;
  const Repeats& repeats;
  double operator()(std::size_t i) const {
    return t[i] - t[0] - static_cast<double>(repeats.empty() ? i : i - repeats[i]) * interval;
  }
  /// A stamp that was written twice is too early for the second sample.
  bool repeated(std::size_t i) const { return i > 0 && t[i] == t[i - 1]; }
  double least(std::size_t begin, std::size_t end) const {
    double value = INFINITY;
    for (std::size_t i = begin; i < end; ++i)
      if (!repeated(i)) value = std::min(value, (*this)(i));
    return std::isfinite(value) ? value : (*this)(begin);
  }
};

/// How much the least departure changes between stretches of 128 samples, two apart, in a record without gaps.
double usual_change(const Departure& r) {
  const std::size_t block = std::clamp<std::size_t>(r.t.size() / 16, 8, 128);
  std::vector<double> least, changes;
  for (std::size_t i = 0; i + block <= r.t.size(); i += block) least.push_back(r.least(i, i + block));
  for (std::size_t k = 2; k < least.size(); ++k) changes.push_back(std::abs(least[k] - least[k - 2]));
  return changes.size() < 4 ? 0.0 : median(changes);
}

/// Whether the stamps from `begin` on, too few to tell a backlog from a loss, look like a backlog coming through.
bool in_a_hurry(const Departure& r, std::size_t begin, bool pauses_are_usual) {
  const std::size_t intervals = r.t.size() - 1 - begin;
  if (intervals == 0) return pauses_are_usual;
  return r.t.back() - r.t[begin] < 0.5 * r.interval * static_cast<double>(intervals);
}

/// A backlog comes through in eight times its own number of samples, surely.
std::size_t window(double lateness, double interval) {
  return static_cast<std::size_t>(std::clamp(8.0 * lateness / interval, 32.0, 4096.0));
}

/// The least departure after sample `i`, over the samples that the backlogs found there need; `before` when it is
/// reached, or when the record ends while one comes through. A lateness that only stays is no new backlog: over many
/// samples the error of the interval would wear it down.
double least_after(const Departure& r, std::size_t i, double before, double tolerance, bool pauses_are_usual) {
  std::size_t end = i + 2;
  double least = r(i + 1), greatest = -INFINITY;
  for (std::size_t j = i + 1; j < end; ++j) {
    if (j == r.t.size()) return in_a_hurry(r, i + 1, pauses_are_usual) ? before : least;
    const double departure = r(j);
    if (!r.repeated(j)) least = std::min(least, departure);
    if (least <= before + tolerance) return before;
    if (departure <= greatest) continue;
    greatest = departure;
    end = std::min(std::max(end, j + window(departure - before, r.interval)), i + window(INFINITY, r.interval));
  }
  return least;
}

void find_gaps(const Departure& r, bool regular, Clock& clock) {
  const Stamps& t = r.t;
  const double tolerance = 0.75 * r.interval + (regular ? 0.0 : 6.0 * usual_change(r));
  std::size_t earliest = 0;  // first sample after the last gap
  for (std::size_t i = 0; i + 1 < t.size(); ++i) {
    const double length = t[i + 1] - t[i];
    if (!(length > 1.5 * r.interval)) continue;
    const std::size_t back = std::min(i + 1, window(length, r.interval));
    const double before = r.least(std::max(earliest, i + 1 - back), i + 1);
    const double rise = least_after(r, i, before, tolerance, clock.longest_pause > 0.0) - before;
    if (rise > tolerance) {
      clock.gaps.push_back(
          {i, t[i], length, static_cast<std::size_t>(std::clamp(std::round(rise / r.interval), 1.0, 1e15))});
      earliest = i + 1;
    } else if (length > clock.longest_pause) {
      clock.longest_pause = length;
      clock.pause_after = i;
    }
  }
}

/// Calls visit(i, x_i, t_i - t_0) with x_i the index that counts the lost samples too, and those written twice once.
template <class Visit>
void visit_stamps(const Stamps& t, const std::vector<Clock::Gap>& gaps, const Repeats& repeats, Visit visit) {
  std::size_t lost = 0;
  auto gap = gaps.begin();
  for (std::size_t i = 0; i < t.size(); ++i) {
    visit(i, static_cast<double>(i + lost - (repeats.empty() ? 0 : repeats[i])), t[i] - t[0]);
    if (gap != gaps.end() && gap->after == i) lost += (gap++)->lost;
  }
}

/// Mean and sum of squares about it of departures [s].
struct Phase {
  double mean = 0.0, squares = 0.0, count = 0.0;
};

Phase phase_of(std::span<const double> r) {
  Phase phase{std::accumulate(r.begin(), r.end(), 0.0) / static_cast<double>(r.size()), 0.0,
              static_cast<double>(r.size())};
  for (const double value : r) phase.squares += (value - phase.mean) * (value - phase.mean);
  return phase;
}

/// Whether the clock ran on while samples were lost: the phase after the gap is that before it, within half a per cent
/// of an interval and four times what the scatter explains. A logger that was stopped and started again begins at any
/// phase.
bool ran_on(const Phase& before, const Phase& after, double interval) {
  const double freedom = before.count + after.count - 2.0;
  if (freedom < 4.0) return true;  // too few to see a difference
  const double variance = (before.squares + after.squares) / freedom * (1.0 / before.count + 1.0 / after.count);
  return std::abs(after.mean - before.mean) < 0.005 * interval + 4.0 * std::sqrt(variance);
}

/// Sums of one stretch in which the clock ran on, about its own level.
struct Level {
  double s = 0, sx = 0, sxx = 0, sr = 0, sxr = 0;
  double slope_weight() const { return sxx - sx * sx / s; }
  double slope_sum() const { return sxr - sx * sr / s; }
};

/// The first sample of each stretch in which the clock ran on, from the departures `r` [s] with the lost samples
/// counted: up to 32 on either side of each gap are compared.
std::vector<std::size_t> starts_of(std::span<const double> r, const std::vector<Clock::Gap>& gaps, double interval) {
  constexpr std::size_t most = 32;
  std::vector<std::size_t> starts{0};
  for (std::size_t k = 0; k < gaps.size(); ++k) {
    const std::size_t begin = gaps[k].after + 1, end = k + 1 == gaps.size() ? r.size() : gaps[k + 1].after + 1;
    const std::size_t before = std::min(most, begin - starts.back()), after = std::min(most, end - begin);
    if (!ran_on(phase_of(r.subspan(begin - before, before)), phase_of(r.subspan(begin, after)), interval))
      starts.push_back(begin);
  }
  return starts;
}

/// Departures from straight lines through the stamps, of one slope for all and a level for each stretch in which the
/// clock ran on, or one for all where it is known that it did; sets the clock's rate.
std::vector<double> about_the_lines(const Stamps& t, double interval, const Repeats& repeats, bool one_line,
                                    Clock& clock) {
  std::size_t lost = 0;
  for (const auto& gap : clock.gaps) lost += gap.lost;
  const double middle = (static_cast<double>(t.size() + lost) - 1.0) / 2.0;
  std::vector<double> r(t.size());
  visit_stamps(t, clock.gaps, repeats,
               [&](std::size_t i, double index, double time) { r[i] = time - index * interval; });
  const auto starts = one_line ? std::vector<std::size_t>{0} : starts_of(r, clock.gaps, interval);
  std::vector<Level> levels(starts.size());
  const auto visit = [&](const auto& use) {
    std::size_t k = 0;
    visit_stamps(t, clock.gaps, repeats, [&](std::size_t i, double index, double) {
      if (k + 1 < starts.size() && starts[k + 1] == i) ++k;
      use(levels[k], (index - middle) / middle, r[i]);
    });
  };
  visit([](Level& level, double x, double& departure) {
    level.s += 1.0, level.sx += x, level.sxx += x * x, level.sr += departure, level.sxr += x * departure;
  });
  double weight = 0.0, sum = 0.0;
  for (const Level& level : levels) weight += level.slope_weight(), sum += level.slope_sum();
  const double slope = weight > 0.0 ? sum / weight : 0.0;
  visit([&](const Level& level, double x, double& departure) {
    departure -= level.sr / level.s + slope * (x - level.sx / level.s);
  });
  clock.rate = 1.0 / (interval + slope / middle);
  return r;
}

/// The rms and greatest change of the departure over `lag` samples, as a fraction of the time these take.
struct Unevenness {
  double rms = 0.0, worst = 0.0;
};

Unevenness unevenness(const std::vector<double>& departures, std::size_t lag, std::size_t step, double rate) {
  Unevenness result;
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + lag < departures.size(); i += step, ++count) {
    const double fraction = (departures[i + lag] - departures[i]) * rate / static_cast<double>(lag);
    sum += fraction * fraction;
    result.worst = std::max(result.worst, std::abs(fraction));
  }
  result.rms = count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count));
  return result;
}

void judge(const std::vector<double>& departures, Clock& clock) {
  const std::size_t n = departures.size(), lag = std::min<std::size_t>(256, std::max<std::size_t>(1, (n - 1) / 4));
  const double local = unevenness(departures, lag, 1, clock.rate).rms;
  const double slow = n < 4096 ? 0.0 : unevenness(departures, n / 16, n / 16, clock.rate).worst;
  std::size_t lost = 0;
  for (const auto& gap : clock.gaps) lost += gap.lost;
  if (clock.backward > 0)
    clock.reason = fmt::format("{} backwards, the first at sample {}",
                               clock.backward == 1 ? "one stamp runs" : fmt::format("{} stamps run", clock.backward),
                               clock.first_backward);
  else if (!clock.gaps.empty())
    clock.reason = fmt::format("{} lost in {}", say_count(lost, "sample"), say_count(clock.gaps.size(), "gap"));
  else if (slow > 0.01) {
    clock.rate_change = slow;
    clock.reason = fmt::format(
        "the rate is not constant: it differs by up to {:.2g} % from its mean over a sixteenth of the record",
        100.0 * slow);
  } else if (local > 0.03) {
    clock.scatter = local, clock.scatter_samples = lag;
    clock.reason = fmt::format("the samples are irregular: the time that {} takes scatters by {:.2g} % rms",
                               say_count(lag, "sample"), 100.0 * local);
  } else {
    clock.even = true;
    clock.reason = fmt::format("the stamps scatter by {} rms about an even clock of {:.6g} Hz",
                               say_seconds(clock.jitter_rms), clock.rate);
  }
}

/// Stamps equal to the one before, and stamps before it.
void count_faults(const Stamps& t, Clock& clock) {
  for (std::size_t i = 1; i < t.size(); ++i) {
    clock.duplicates += t[i] == t[i - 1];
    if (t[i] < t[i - 1] && clock.backward++ == 0) clock.first_backward = i;
  }
}

/// How far the stamps are from an even clock.
void take_departures(const std::vector<double>& departures, Clock& clock) {
  double sum = 0.0;
  for (const double r : departures) {
    sum += r * r;
    clock.worst = std::max(clock.worst, std::abs(r));
  }
  clock.jitter_rms = std::sqrt(sum / static_cast<double>(departures.size()));
}

}  // namespace

Clock clock_of(const Channel& channel) {
  Clock clock;
  if (channel.timeline.uniform()) {
    clock.rate = channel.timeline.rate;
    clock.even = true;
    clock.reason = "evenly sampled by definition";
    return clock;
  }
  const Stamps& t = *channel.timeline.stamps;
  if (t.size() < 3) {
    clock.rate = mean_rate(channel);
    clock.reason = "fewer than three stamps";
    return clock;
  }
  count_faults(t, clock);
  const double stated = channel.timeline.rate > 0.0 ? 1.0 / channel.timeline.rate : 0.0;
  const bool twice = clock.duplicates > 0 && written_twice(channel);
  auto [ticks, other_interval] = clock.backward > 0 ? Ticks{} : twice ? ticked_once(t, stated) : ticked(t, stated);
  clock.other_rate = other_interval > 0.0 ? 1.0 / other_interval : 0.0;
  const auto [interval, regular] = ticks ? Period{ticks->interval, true} : period(t);
  if (!(interval > 0.0) || !std::isfinite(interval) || !std::isfinite(t.back() - t.front())) {
    clock.reason = "the stamps do not advance";
    return clock;
  }
  const Repeats repeats = regular && twice ? repeats_in(t) : Repeats();
  if (ticks)
    for (const auto& [after, lost] : ticks->gaps)
      clock.gaps.push_back({after, t[after], t[after + 1] - t[after], lost});
  else
    find_gaps(Departure{t, interval, repeats}, regular, clock);
  const auto departures = about_the_lines(t, interval, repeats, ticks.has_value(), clock);
  take_departures(departures, clock);
  judge(departures, clock);
  return clock;
}

}  // namespace tumble
