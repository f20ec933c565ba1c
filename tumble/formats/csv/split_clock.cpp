#include "tumble/formats/csv/split_clock.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "tumble/formats/csv/cells.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::csv {

namespace {

constexpr std::int64_t whole_second = 1'000'000'000;  // [ns]
constexpr std::int64_t whole_hour = static_cast<std::int64_t>(hour) * whole_second;
constexpr std::int64_t whole_day = 24 * whole_hour;

enum class ClockPart { none, year, month, day, day_of_year, hour, minute, second, second_of_day, month_or_minute };

/// What the names of a part end in, and the numbers that it may have.
struct PartKind {
  ClockPart part;
  std::initializer_list<std::string_view> words;
  std::initializer_list<std::string_view> units;
  StampFormat format;
};

const std::array<PartKind, 9>& part_kinds() {
  const auto number = [](std::int64_t unit, std::int64_t count) {
    return StampFormat{StampKind::number, DateOrder::open, unit, unit * count};
  };
  static const std::array<PartKind, 9> kinds{
      {{ClockPart::day_of_year,
        {"day_of_year", "day of year", "dayofyear", "doy", "yday", "jday", "julian_day", "julian day", "年积日"},
        {"d", "day"},
        number(whole_day, 367)},
       {ClockPart::second_of_day,
        {"second_of_day", "seconds_of_day", "second of day", "seconds of day", "secofday", "sod"},
        {"s"},
        number(whole_second, 86401)},
       {ClockPart::month_or_minute, {"mm"}, {"min"}, {}},
       {ClockPart::year,
        {"year", "years", "yyyy", "yy", "jahr", "año", "année", "年"},
        {"y", "yr", "a"},
        number(1, 2200)},
       {ClockPart::month, {"month", "months", "mon", "mo", "monat", "mes", "mois", "月"}, {}, number(1, 13)},
       {ClockPart::day, {"day", "days", "dd", "tag", "día", "dia", "jour", "日"}, {"d", "day"}, number(1, 32)},
       // 10 000 hours: a logger may count the hours since its start
       {ClockPart::hour,
        {"hour", "hours", "hh", "hr", "hrs", "stunde", "stunden", "heure", "heures", "hora", "时", "小时", "h"},
        {"h"},
        number(whole_hour, 10'000)},
       {ClockPart::minute,
        {"minute", "minutes", "min", "mins", "mi", "minuten", "minuto", "minutos", "分", "分钟", "m"},
        {"min"},
        number(60 * whole_second, 60)},
       {ClockPart::second,
        {"second", "seconds", "sec", "secs", "ss", "sekunde", "sekunden", "seconde", "secondes", "segundo", "segundos",
         "秒", "s"},
        {"s"},
        number(whole_second, 61)}}};  // 60: a leap second
  return kinds;
}

const PartKind& kind_of_part(ClockPart part) { return *std::ranges::find(part_kinds(), part, &PartKind::part); }

/// A column that may be part of a clock: what it holds, and what stands before it in its name: "utc_" of "utc_hour".
struct ClockWord {
  ClockPart part = ClockPart::none;
  std::string before;
  bool fits = true;  ///< its first numbers are those of such a part
};

ClockWord word_of(const std::string& name) {
  const std::string lower = lower_case(name);
  for (const PartKind& kind : part_kinds())
    for (const std::string_view word : kind.words) {
      if (!lower.ends_with(word)) continue;
      const std::string before = lower.substr(0, lower.size() - word.size());
      if (before.empty() || std::string_view("_ ./-").find(before.back()) != std::string_view::npos)
        return {kind.part, before, true};
    }
  return {};
}

bool is_whole(double value) { return std::floor(value) == value; }

/// Whole numbers from zero to less than the format allows.
bool counts_in_whole(const ColumnSample& sample, const StampFormat& format) {
  return sample.numbers && !sample.text && sample.kind == StampKind::none && sample.first >= 0.0 &&
         sample.last >= 0.0 && is_whole(sample.first) && is_whole(sample.last) && is_whole(sample.step) &&
         is_whole(sample.greatest) &&
         sample.greatest * static_cast<double>(format.unit) < static_cast<double>(format.below);
}

/// The columns of a table by the part of a clock that they hold.
class ClockWords {
 public:
  ClockWords(const std::vector<ColumnName>& names, const std::vector<ColumnSample>& samples)
      : names_(names), samples_(samples) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      ClockWord word = names[i].cell == not_read ? ClockWord() : word_of(names[i].name);
      if (word.part == ClockPart::month_or_minute)
        word.part = i > 0 && words_.back().part == ClockPart::hour ? ClockPart::minute : ClockPart::month;
      word.fits = word.part != ClockPart::none && holds_part(i, kind_of_part(word.part));
      words_.push_back(word);
    }
  }

  /// The only column of that part with such a beginning of its name.
  std::size_t find(ClockPart part, const std::string& before) const {
    std::size_t found = no_column;
    for (std::size_t i = 0; i < words_.size(); ++i) {
      if (words_[i].part != part || words_[i].before != before || !words_[i].fits) continue;
      if (found != no_column) return no_column;
      found = i;
    }
    return found;
  }
  /// Whether a column has the name of that part and other numbers.
  bool misfits(ClockPart part, const std::string& before) const {
    return std::ranges::any_of(
        words_, [&](const ClockWord& word) { return word.part == part && word.before == before && !word.fits; });
  }
  /// The only column of such stamps.
  std::size_t find(StampKind kind) const {
    std::size_t found = no_column;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      if (samples_[i].kind != kind || names_[i].cell == not_read) continue;
      if (found != no_column) return no_column;
      found = i;
    }
    return found;
  }
  const std::vector<ClockWord>& all() const { return words_; }
  const ColumnName& name(std::size_t column) const { return names_[column]; }

 private:
  bool holds_part(std::size_t column, const PartKind& kind) const {
    const std::string& unit = names_[column].unit;
    const bool fits = unit.empty() || unit == "1" || std::ranges::find(kind.units, unit) != kind.units.end();
    const bool fractions = kind.part == ClockPart::second || kind.part == ClockPart::second_of_day;
    const ColumnSample& sample = samples_[column];
    if (!fits) return false;
    if (!fractions) return counts_in_whole(sample, kind.format);
    return sample.numbers && !sample.text && sample.kind == StampKind::none && sample.first >= 0.0 &&
           sample.greatest * 1e9 < static_cast<double>(kind.format.below);
  }

  const std::vector<ColumnName>& names_;
  const std::vector<ColumnSample>& samples_;
  std::vector<ClockWord> words_;
};

/// The columns of the date before those of the time of day; none where there is no date.
void add_date(const ClockWords& words, const std::string& before, Clock& clock) {
  const auto found = [&](ClockPart part) { return words.find(part, before); };
  const auto add = [&](std::initializer_list<ClockPart> parts) {
    for (const ClockPart part : parts) clock.columns.push_back({found(part), kind_of_part(part).format});
  };
  const bool year = found(ClockPart::year) != no_column, numbered = found(ClockPart::day_of_year) != no_column;
  if (const std::size_t date = words.find(StampKind::date); date != no_column) {
    clock.columns.push_back({date, {StampKind::date}});
  } else if (year && found(ClockPart::month) != no_column && found(ClockPart::day) != no_column) {
    clock.date = DateColumns::year_month_day;
    add({ClockPart::year, ClockPart::month, ClockPart::day});
  } else if (year && numbered) {
    clock.date = DateColumns::year_day;
    add({ClockPart::year, ClockPart::day_of_year});
    clock.columns.back().format = {StampKind::number, DateOrder::open, 1, 367};
  } else if (numbered) {
    add({ClockPart::day_of_year});
    clock.turn = Turn::year;
  } else {
    clock.turn = Turn::day;
  }
}

/// The columns of the time of day. False where they are not there.
bool add_time_of_day(const ClockWords& words, std::size_t column, Clock& clock) {
  const auto& [part, before, fits] = words.all()[column];
  if (part == ClockPart::second_of_day) {
    clock.columns.push_back({column, kind_of_part(part).format});
    return clock.columns.size() > 1;  // alone it is a plain number
  }
  const std::size_t minute = words.find(ClockPart::minute, before), second = words.find(ClockPart::second, before);
  if (part != ClockPart::hour || minute == no_column || words.misfits(ClockPart::second, before)) return false;
  const bool dated = clock.turn == Turn::none || clock.turn == Turn::year;
  StampFormat hours = kind_of_part(part).format;
  if (dated) hours.below = whole_day;
  clock.columns.push_back({column, hours});
  clock.columns.push_back({minute, kind_of_part(ClockPart::minute).format});
  if (second != no_column) clock.columns.push_back({second, kind_of_part(ClockPart::second).format});
  // One letter names too much: x, y, h, m. Only three beside each other are a clock.
  const bool letters = words.name(column).name.size() == 1 || words.name(minute).name.size() == 1;
  return !letters || (minute == column + 1 && second == column + 2);
}

std::string names_of_parts(const std::vector<ColumnName>& names, const Clock& clock) {
  std::string text;
  for (std::size_t i = 0; i < clock.columns.size(); ++i)
    text += (i == 0                         ? ""
             : i + 1 < clock.columns.size() ? ", "
                                            : " and ") +
            in_quotes(names[clock.columns[i].index].name);
  return text;
}

/// [ns] of the unit that a column of fractions of a second has by its name; 0: it is no such column.
std::int64_t fraction_unit(const std::string& name) {
  const std::string lower = lower_case(name);
  const auto one_of = [&](std::initializer_list<std::string_view> words) {
    return std::ranges::find(words, lower) != words.end();
  };
  if (one_of({"ms", "msec", "msecs", "millis", "millisec", "millisecond", "milliseconds", "millisekunden", "毫秒"}))
    return 1'000'000;
  if (one_of({"us", "usec", "usecs", "micros", "microsec", "microsecond", "microseconds", "mikrosekunden", "微秒"}))
    return 1000;
  return one_of({"ns", "nsec", "nsecs", "nanosec", "nanosecond", "nanoseconds", "nanosekunden", "纳秒"}) ? 1 : 0;
}

}  // namespace

void add_fractions(const std::vector<ColumnName>& names, const std::vector<ColumnSample>& samples, Clock& clock) {
  std::int64_t below = whole_second;
  for (const std::int64_t unit : {std::int64_t{1'000'000}, std::int64_t{1000}, std::int64_t{1}})
    for (std::size_t i = 0; i < names.size(); ++i) {
      const StampFormat format{StampKind::number, DateOrder::open, unit, below};
      const bool fits = fraction_unit(names[i].name) == unit && names[i].cell != not_read && !clock.uses(i) &&
                        samples[i].numbers && !samples[i].text &&
                        samples[i].greatest * static_cast<double>(unit) < static_cast<double>(below);
      if (!fits) continue;
      clock.columns.push_back({i, format});
      clock.how += ", and " + in_quotes(names[i].name) + (unit == 1 ? " in ns" : unit == 1000 ? " in us" : " in ms");
      below = unit;
      break;
    }
}

std::optional<Clock> split_clock(const std::vector<ColumnName>& names, const std::vector<ColumnSample>& samples) {
  const ClockWords words(names, samples);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const ClockWord& word = words.all()[i];
    if (!word.fits || (word.part != ClockPart::hour && word.part != ClockPart::second_of_day)) continue;
    Clock clock;
    add_date(words, word.before, clock);
    if (!add_time_of_day(words, i, clock)) continue;
    clock.how = names_of_parts(names, clock);
    const ClockColumn& last = clock.columns.back();
    const ColumnSample& seconds = samples[last.index];
    if (last.format.unit == whole_second && is_whole(seconds.first) && is_whole(seconds.last) && is_whole(seconds.step))
      add_fractions(names, samples, clock);
    return clock;
  }
  // Year, month and day before a column of times of day.
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (words.all()[i].part != ClockPart::year || words.find(StampKind::time_of_day) == no_column) continue;
    Clock clock;
    add_date(words, words.all()[i].before, clock);
    if (clock.date == DateColumns::none) continue;
    clock.columns.push_back({words.find(StampKind::time_of_day), {StampKind::time_of_day}});
    clock.how = names_of_parts(names, clock);
    return clock;
  }
  return std::nullopt;
}

std::optional<std::int64_t> midnight_of(DateColumns columns, std::int64_t year, std::int64_t month_or_day,
                                        std::int64_t day) {
  using namespace std::chrono;
  const std::chrono::year calendar_year(static_cast<int>(year < 100 ? year + 2000 : year));
  if (calendar_year < std::chrono::year(1700)) return std::nullopt;
  sys_days date = sys_days(calendar_year / January / 1);
  if (columns == DateColumns::year_month_day) {
    const auto written = calendar_year / static_cast<int>(month_or_day) / static_cast<int>(day);
    if (!written.ok()) return std::nullopt;
    date = sys_days(written);
  } else {
    if (month_or_day < 1 || month_or_day > (calendar_year.is_leap() ? 366 : 365)) return std::nullopt;
    date += days(month_or_day - 1);
  }
  return date.time_since_epoch().count() * whole_day;
}

}  // namespace tumble::csv
