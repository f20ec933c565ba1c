#include "tumble/formats/csv/clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/split_clock.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::csv {

namespace {

/// [s] The longest interval of a logger. With a longer one the numbers rather count a smaller unit since the start of
/// the device: 1.2e9 us are 20 minutes (PX4), 1.2e15 ns are 14 days (Android).
double longest_interval(std::int64_t unit) { return unit == 1000 ? 0.5 : unit == 1 ? INFINITY : 600.0; }

/// [ns] of the unit in which numbers of that size are Unix time of the years 2001 to 2103; 0: in none.
std::int64_t unix_unit(const ColumnSample& sample, bool unit_is_said) {
  if (sample.text || sample.empty || sample.kind != StampKind::none) return 0;
  for (std::int64_t unit = 1; unit <= 1'000'000'000; unit *= 1000) {
    const double seconds = static_cast<double>(unit) * 1e-9;
    const auto fits = [&](double value) { return value * seconds >= 1e9 && value * seconds < 4.2e9; };
    if (fits(sample.first) && fits(sample.last))
      return unit_is_said || sample.step * seconds <= longest_interval(unit) ? unit : 0;
  }
  return 0;
}

/// [s] LabVIEW counts seconds since 1904: from here on, which is the year 2014 by it and 2080 by Unix time.
constexpr double least_since_1904 = 3.5e9;
/// [ns] Unix time of 1904-01-01: 66 years with 17 leap days before 1970.
constexpr std::int64_t begin_of_1904 = -(66 * 365 + 17) * std::int64_t{86'400} * 1'000'000'000;

bool is_since_1904(const ColumnSample& sample, std::int64_t unit) {
  return unit == 1'000'000'000 && sample.first >= least_since_1904;
}

std::string unit_name(std::int64_t unit) {
  return unit == 1 ? "ns" : unit == 1000 ? "us" : unit == 1'000'000 ? "ms" : "s";
}

/// [ns] of the unit, where a whole number of them is one; else 0.
std::int64_t nanoseconds_of(const std::string& unit) {
  try {
    const Unit parsed = parse_written_unit(unit);
    if (kind_of(parsed) != QuantityKind::time || parsed.factor() > 1.0) return 0;
    return std::llround(parsed.factor() * 1e9);
  } catch (const Error&) {
    return 0;
  }
}

/// Behind the last "." or "/": "header.stamp" has the part "stamp".
std::string_view last_part(std::string_view name) {
  const auto at = name.find_last_of("./");
  return at == name.npos ? name : name.substr(at + 1);
}

bool one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

/// Clocks by name, the best first: 1 the stamp of a ROS header, 5 the time at which a message was received; 0: no
/// clock.
int rank_of(const std::string& name) {
  const std::string lower = lower_case(name);
  if (lower.ends_with("header.stamp") || lower.ends_with("header/stamp")) return 1;
  if (one_of(lower, {"__time", "%time", "rosbagtimestamp", "log_time", "receive_time"})) return 5;
  const std::string_view part = last_part(lower);
  if (part == "stamp") return 2;
  if (one_of(part, {"timestamp", "time_stamp", "time stamp", "timestamps", "sensor_time", "zeitstempel", "horodatage",
                    "时间戳"}))
    return 3;
  if (one_of(lower, {"time",          "t",
                     "zeit",          "uhrzeit",
                     "datum",         "date",
                     "datetime",      "date_time",
                     "date time",     "date/time",
                     "datum/zeit",    "datum uhrzeit",
                     "datum/uhrzeit", "date/heure",
                     "date heure",    "temps",
                     "heure",         "x_value",
                     "elapsed",       "elapsed_time",
                     "elapsed time",  "seconds_elapsed",
                     "时间",          "日期",
                     "时刻",          "日期时间",
                     "采样时间"}))
    return 4;
  return 0;
}

/// "time_us", "timestamp_ns", "TimeUS": the unit that the name of a clock ends with.
std::string unit_in_name(const std::string& name) {
  if (name == "TimeUS") return "us";
  if (name == "TimeMS") return "ms";
  if (lower_case(name) == "millis") return "ms";  // as Arduino calls its clocks
  if (lower_case(name) == "micros") return "us";
  const auto at = name.find_last_of("_- ");
  if (at == std::string::npos) return "";
  const std::string unit = lower_case(name.substr(at + 1));
  if (rank_of(name.substr(0, at)) == 0 ||
      !one_of(unit, {"s", "sec", "seconds", "ms", "msec", "us", "usec", "ns", "nsec"}))
    return "";
  return unit;
}

/// A clock that may be chosen.
struct Candidate {
  int rank = 0;
  Clock clock;
};

/// Everything that is known of the columns.
struct Columns {
  const std::vector<ColumnName>& names;
  const std::vector<ColumnSample>& samples;

  std::size_t find(const std::string& name) const {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i].name == name || names[i].cell == name) return i;
    return no_column;
  }
  std::size_t only(StampKind kind) const {
    std::size_t found = no_column;
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (samples[i].kind == kind && names[i].cell != not_read) {
        if (found != no_column) return no_column;
        found = i;
      }
    return found;
  }
};

/// Seconds beside nanoseconds or microseconds of one stamp.
std::optional<Candidate> split_stamp(const Columns& table, std::size_t column) {
  const std::string name = lower_case(table.names[column].name);
  const std::string part(last_part(name)), before = name.substr(0, name.size() - part.size());
  if (!one_of(part, {"sec", "secs", "seconds", "tv_sec", "stamp_sec", "timestamp_sec"})) return std::nullopt;
  const std::string joined = part.substr(0, part.rfind("sec") == std::string::npos ? 0 : part.find("sec"));
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    const std::string other = lower_case(table.names[i].name);
    const std::string head = before + joined;
    if (!other.starts_with(head)) continue;
    const std::string_view tail = std::string_view(other).substr(head.size());
    const bool nano = one_of(tail, {"nanosec", "nanosecs", "nsec", "nsecs", "nanoseconds"});
    const bool micro = one_of(tail, {"usec", "usecs", "microsec", "microseconds"});
    if ((!nano && !micro) || table.samples[i].text || table.samples[column].text) continue;
    Candidate candidate;
    candidate.rank = before.ends_with("header.stamp.") || before.ends_with("header/stamp/") ? 1
                     : before.ends_with("stamp.") || before.ends_with("stamp/")             ? 2
                                                                                            : 3;
    candidate.clock.columns = {{column, {StampKind::number, DateOrder::open, 1'000'000'000}},
                               {i, {StampKind::number, DateOrder::open, nano ? 1 : 1000}}};
    candidate.clock.how = in_quotes(table.names[column].name) + " in s and " + in_quotes(table.names[i].name) +
                          (nano ? " in ns" : " in us");
    return candidate;
  }
  return std::nullopt;
}

/// A column of dates, times of day, or both; the date is completed by the only column with times of day.
std::optional<Candidate> calendar(const Columns& table, std::size_t column) {
  const StampKind kind = table.samples[column].kind;
  if (kind == StampKind::none) return std::nullopt;
  const std::string name = in_quotes(table.names[column].name);
  Candidate candidate;
  candidate.clock.columns = {{column, {kind}}};
  const int rank = rank_of(table.names[column].name);
  candidate.rank = rank > 0 ? rank : 6;
  if (kind == StampKind::date_time) candidate.clock.how = name + ", date and time";
  if (kind == StampKind::date) {
    const std::size_t time = table.only(StampKind::time_of_day);
    if (time == no_column) return std::nullopt;
    candidate.rank = 3;
    candidate.clock.columns.push_back({time, {StampKind::time_of_day}});
    candidate.clock.how = name + ", date, and " + in_quotes(table.names[time].name) + ", time of day";
  }
  if (kind == StampKind::time_of_day) {
    if (table.only(StampKind::date) != no_column && table.only(StampKind::time_of_day) == column) return std::nullopt;
    candidate.rank += 1;
    candidate.clock.turn = Turn::day;
    candidate.clock.how = name + ", time of day";
  }
  const auto whole = [](const std::string& cell) {
    return std::ranges::count(cell, ':') == 2 && cell.find_first_of(".,", cell.rfind(':')) == cell.npos;
  };
  if (std::ranges::all_of(table.samples[candidate.clock.columns.back().index].cells, whole))
    add_fractions(table.names, table.samples, candidate.clock);
  return candidate;
}

/// A column of numbers that by its name is a clock, or that the user says is one.
std::optional<Candidate> numbers(const Columns& table, std::size_t column, bool said) {
  const ColumnName& name = table.names[column];
  const ColumnSample& sample = table.samples[column];
  if (sample.kind != StampKind::none || (sample.text && !said)) return std::nullopt;
  Candidate candidate;
  candidate.rank = rank_of(name.name);
  candidate.clock.columns = {{column}};
  std::string unit = name.unit;
  const std::string in_name = unit_in_name(name.name);
  if (unit.empty() && !in_name.empty()) {
    unit = candidate.clock.unit = in_name;
    if (candidate.rank == 0) candidate.rank = 4;
  }
  const bool ours = is_time(name.name, unit) && name.from != UnitFrom::nowhere;  // time[s]: as it is written
  if (ours) candidate.rank = 1;
  if (candidate.rank == 0 && !said) return std::nullopt;
  const bool known = !unit.empty();
  const std::int64_t by_size = unix_unit(sample, known);
  const std::int64_t stated = known ? nanoseconds_of(unit) : 0;
  if (known && kind_of(parse_written_unit(unit)) != QuantityKind::time && !said && !ours) return std::nullopt;
  if (!ours && by_size > 0 && (!known || stated == by_size)) {
    const bool labview = is_since_1904(sample, by_size);
    candidate.clock.columns.front().format = {StampKind::number, DateOrder::open, by_size, 0,
                                              labview ? begin_of_1904 : 0};
    candidate.clock.how = in_quotes(name.name) +
                          (labview ? ", seconds since 1904" : ", Unix time in " + unit_name(by_size)) +
                          (known ? "" : ", as the size of its numbers shows");
  } else if (!ours && known) {
    candidate.clock.how = in_quotes(name.name) + " in " + unit;
  } else if (!known) {
    candidate.rank += 10;  // its unit must be said
  }
  return candidate;
}

std::vector<Candidate> candidates_of(const Columns& table) {
  std::vector<Candidate> candidates;
  if (auto clock = split_clock(table.names, table.samples)) candidates.push_back({3, *clock});
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    if (table.names[i].cell == not_read) continue;
    try {
      if (auto pair = split_stamp(table, i))
        candidates.push_back(*pair);
      else if (auto stamp = calendar(table, i))
        candidates.push_back(*stamp);
      else if (auto number = numbers(table, i, false))
        candidates.push_back(*number);
    } catch (const Error&) {  // a unit that cannot be read is a problem of its column
    }
  }
  return candidates;
}

/// The clock in the column that the user names. Throws nothing: a problem is noted.
Clock said_clock(const Columns& table, const std::string& said, Problems& problems) {
  const std::size_t column = table.find(said);
  if (column == no_column) {
    std::vector<std::string> known, shown;
    for (const ColumnName& name : table.names) known.push_back(name.name), shown.push_back(plain_text(name.name, 60));
    problems.push_back(
        say("no column '{}' for time{}; columns are {}", said, did_you_mean(said, known), fmt::join(shown, ", ")));
    return {};
  }
  try {
    if (auto split = split_clock(table.names, table.samples); split && split->uses(column)) return *split;
    if (auto pair = split_stamp(table, column)) return pair->clock;
    if (auto stamp = calendar(table, column)) return stamp->clock;
    if (auto number = numbers(table, column, true)) return number->clock;
  } catch (const Error&) {  // its unit: a problem of the column
    Clock clock;
    clock.columns = {{column}};
    return clock;
  }
  problems.push_back(say("column '{}' for time: it holds neither numbers nor times", plain_text(said, 60)));
  return {};
}

/// The order of the numbers of a date, from all dates in sight; asked for where both day and month can come first.
DateOrder order_of(const ColumnSample& sample, const std::string& name, const std::string& said, Problems& problems,
                   std::vector<std::string>& proposals) {
  if (said == "dmy") return DateOrder::dmy;
  if (said == "mdy") return DateOrder::mdy;
  if (said == "ymd") return DateOrder::ymd;
  AllowedOrders all{true, true, true, false};
  bool plain = true;
  for (const std::string& cell : sample.cells) {
    const AllowedOrders allowed = allowed_orders(cell);
    plain = plain && allowed.plain;
    all.dmy = all.dmy && allowed.dmy;
    all.mdy = all.mdy && allowed.mdy;
    all.ymd = all.ymd && allowed.ymd;
  }
  if (plain) return DateOrder::open;
  const int choices = static_cast<int>(all.dmy) + static_cast<int>(all.mdy) + static_cast<int>(all.ymd);
  if (choices == 1) return all.dmy ? DateOrder::dmy : all.mdy ? DateOrder::mdy : DateOrder::ymd;
  if (choices > 1) {
    problems.push_back(
        say("column '{}': in '{}' day and month can be meant in either order; say --set date=dmy (day first) or --set "
            "date=mdy{}",
            plain_text(name, 60), plain_text(sample.cells.front(), 60), all.ymd ? " or --set date=ymd" : ""));
    proposals.emplace_back("date=dmy");
  }
  return DateOrder::dmy;
}

/// Columns that by their names are clocks, and hold what is no number and no time that is understood: a problem each.
std::vector<std::size_t> unread_clocks(const Columns& table, const ReadOptions& options, Problems& problems) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    const ColumnName& name = table.names[i];
    const ColumnSample& sample = table.samples[i];
    if (rank_of(name.name) == 0 || name.name == options.segment_column || name.cell == not_read || sample.numbers ||
        sample.other.empty())
      continue;
    found.push_back(i);
    problems.push_back(
        say("column '{}': '{}' is no time that is understood; understood are dates such as 2026-11-20 09:00:00.5, "
            "2026-11-20T09:00:00Z, 20.11.2026 09:00:00, 20-Nov-2026 09:00:00, 11/20/2026 9:00 AM, times of day, and "
            "numbers in a unit of time; or do without: --set time=- --set rate=100",
            plain_text(name.name, 60), plain_text(sample.other, 60)));
  }
  return found;
}

}  // namespace

bool is_time(const std::string& name, const std::string& unit) {
  if (name == "t") {
    for (const char* known : {"s", "ms", "us", "ns", "min", "h"})
      if (unit == known) return true;
    return false;
  }
  return lower_case(name) == "time";
}

Clock clock_of(const std::vector<ColumnName>& names, const std::vector<ColumnSample>& samples,
               const ReadOptions& options, Problems& problems, std::vector<std::string>& proposals) {
  const Columns table{names, samples};
  if (options.time == not_read) return {};
  std::vector<Candidate> candidates = candidates_of(table);
  Clock chosen;
  if (!options.time.empty()) {
    chosen = said_clock(table, options.time, problems);
    if (chosen.columns.empty()) return chosen;
  } else {
    const auto best = std::ranges::min_element(candidates, {}, &Candidate::rank);
    if (best == candidates.end()) {
      if (!options.rate) chosen.others = unread_clocks(table, options, problems);
      return chosen;
    }
    chosen = best->clock;
  }
  for (const Candidate& candidate : candidates)
    for (const ClockColumn& column : candidate.clock.columns)
      if (!chosen.uses(column.index)) chosen.others.push_back(column.index);
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (samples[i].kind != StampKind::none && !chosen.uses(i) &&
        std::ranges::find(chosen.others, i) == chosen.others.end())
      chosen.others.push_back(i);
  const bool parts = chosen.date != DateColumns::none || chosen.turn != Turn::none;
  chosen.zoned = chosen.kind() == StampKind::number && !parts;
  if (chosen.kind() == StampKind::date || chosen.kind() == StampKind::date_time) {
    auto& [column, format] = chosen.columns.front();
    const ColumnSample& sample = samples[column];
    format.order = order_of(sample, names[column].name, options.date, problems, proposals);
    Stamp first;
    chosen.zoned = !sample.cells.empty() && parse_stamp(sample.cells.front(), format, first) && first.zoned;
  }
  return chosen;
}

}  // namespace tumble::csv
