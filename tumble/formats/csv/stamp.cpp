#include "tumble/formats/csv/stamp.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/number.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::csv {

namespace {

constexpr std::int64_t nanoseconds = 1'000'000'000;
constexpr auto seconds_of_hour = static_cast<std::int64_t>(hour);
constexpr std::int64_t seconds_of_day = 24 * seconds_of_hour;
constexpr std::int64_t latest = 4'500'000'000;  // [s] the year 2112: the sum of two numbers stays within 64 bits of ns

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Takes from the front of a text.
struct Scanner {
  std::string_view text;

  bool ended() const { return text.empty(); }
  bool take(std::string_view token) {
    if (!text.starts_with(token)) return false;
    text.remove_prefix(token.size());
    return true;
  }
  void skip_blanks() {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  }
  /// Up to `most` digits; how many there were.
  int digits(int most, std::int64_t& value) {
    int count = 0;
    value = 0;
    for (; count < most && !text.empty() && is_digit(text.front()); ++count, text.remove_prefix(1))
      value = 10 * value + (text.front() - '0');
    return count;
  }
};

/// The three numbers of a date as written.
struct DateParts {
  std::int64_t numbers[3] = {0, 0, 0};
  int digits[3] = {0, 0, 0};
  char separator = 0;
  bool named = false;  ///< the month is a word: day, month, year

  bool year_first() const { return !named && digits[0] == 4; }
};

std::int64_t month_named(std::string_view word) {
  constexpr std::string_view names[] = {"jan", "feb", "mar", "apr", "may", "jun",
                                        "jul", "aug", "sep", "oct", "nov", "dec"};
  const std::string lower = lower_case(word);
  for (std::size_t i = 0; i < std::size(names); ++i)
    if (lower.starts_with(names[i])) return static_cast<std::int64_t>(i) + 1;
  return 0;
}

/// The separator before the next number of a date: - / . or that of the number before; blanks only before a word.
bool take_separator(Scanner& scanner, char& separator) {
  for (const std::string_view ideograph : {"年", "月"})
    if (scanner.take(ideograph)) return true;
  if (scanner.ended()) return false;
  const char c = scanner.text.front();
  if (c != '-' && c != '/' && c != '.' && c != ' ') return false;
  if (separator != 0 && c != separator) return false;
  separator = c;
  scanner.text.remove_prefix(1);
  return true;
}

std::optional<DateParts> take_date(Scanner& scanner) {
  DateParts parts;
  parts.digits[0] = scanner.digits(4, parts.numbers[0]);
  if (parts.digits[0] == 0 || !take_separator(scanner, parts.separator)) return std::nullopt;
  std::size_t letters = 0;
  while (letters < scanner.text.size() && std::isalpha(static_cast<unsigned char>(scanner.text[letters])) != 0)
    ++letters;
  if (letters > 0) {
    parts.numbers[1] = month_named(scanner.text.substr(0, letters));
    parts.digits[1] = 2;
    parts.named = true;
    scanner.text.remove_prefix(letters);
    if (parts.numbers[1] == 0) return std::nullopt;
  } else {
    if (parts.separator == ' ') return std::nullopt;
    parts.digits[1] = scanner.digits(2, parts.numbers[1]);
  }
  if (parts.digits[1] == 0 || !take_separator(scanner, parts.separator)) return std::nullopt;
  parts.digits[2] = scanner.digits(4, parts.numbers[2]);
  scanner.take("日");
  const bool years = parts.digits[2] == 4 || parts.digits[2] == 2 || (parts.year_first() && parts.digits[2] == 1);
  if (!years || parts.digits[0] == 3) return std::nullopt;
  return parts;
}

/// [days] since 1970-01-01; none for a date that the calendar does not have.
std::optional<std::int64_t> day_of(const DateParts& parts, DateOrder order) {
  if (parts.year_first()) order = DateOrder::ymd;
  if (parts.named) order = parts.digits[0] == 4 ? DateOrder::ymd : DateOrder::dmy;
  if (order == DateOrder::open) return std::nullopt;
  const int year_index = order == DateOrder::ymd ? 0 : 2;
  std::int64_t year = parts.numbers[year_index];
  if (parts.digits[year_index] <= 2) year += 2000;
  const auto month = parts.numbers[order == DateOrder::mdy ? 0 : 1];
  const auto day = parts.numbers[order == DateOrder::ymd ? 2 : order == DateOrder::dmy ? 0 : 1];
  using namespace std::chrono;
  if (year < 1700 || year > 2200 || month > 12 || day > 31) return std::nullopt;
  const year_month_day date{std::chrono::year(static_cast<int>(year)), std::chrono::month(static_cast<unsigned>(month)),
                            std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  return sys_days(date).time_since_epoch().count();
}

/// Digits behind a decimal mark [ns]; what is finer is cut off.
std::int64_t take_fraction(Scanner& scanner, int& place) {
  std::int64_t value = 0;
  const int count = scanner.digits(9, value);
  place = -count;
  for (int i = count; i < 9; ++i) value *= 10;
  std::int64_t finer = 0;
  while (scanner.digits(9, finer) > 0) {
  }
  return value;
}

/// "9:00:00.123 PM"; what follows stays.
bool take_clock(Scanner& scanner, Stamp& stamp) {
  std::int64_t hours = 0, minutes = 0, seconds = 0;
  if (scanner.digits(2, hours) == 0 || !scanner.take(":") || scanner.digits(2, minutes) != 2) return false;
  stamp.place = 0;
  std::int64_t fraction = 0;
  if (scanner.take(":")) {
    if (scanner.digits(2, seconds) == 0) return false;
    if (scanner.take(".") || scanner.take(",") || scanner.take(":")) fraction = take_fraction(scanner, stamp.place);
  }
  Scanner behind = scanner;
  behind.skip_blanks();
  for (const std::string_view half : {"AM", "PM", "am", "pm", "a.m.", "p.m."})
    if (behind.take(half)) {
      if (hours < 1 || hours > 12) return false;
      hours = hours % 12 + (half.front() == 'P' || half.front() == 'p' ? 12 : 0);
      scanner = behind;
      break;
    }
  if (hours > 23 || minutes > 59 || seconds > 60) return false;
  stamp.time = (hours * seconds_of_hour + minutes * 60 + seconds) * nanoseconds + fraction;
  return true;
}

/// "Z", "+08:00", " UTC": subtracted from the stamp. Nothing is no zone.
bool take_zone(Scanner& scanner, Stamp& stamp) {
  scanner.skip_blanks();
  if (scanner.ended()) return true;
  stamp.zoned = true;
  if (scanner.take("Z") || scanner.take("UTC") || scanner.take("GMT")) return scanner.ended();
  const bool west = scanner.text.front() == '-';
  if (!west && scanner.text.front() != '+') return false;
  scanner.text.remove_prefix(1);
  std::int64_t hours = 0, minutes = 0;
  if (scanner.digits(2, hours) != 2) return false;
  scanner.take(":");
  const int digits = scanner.digits(2, minutes);
  if ((digits != 0 && digits != 2) || hours > 18 || minutes > 59) return false;
  stamp.time -= (west ? -1 : 1) * (hours * seconds_of_hour + minutes * 60) * nanoseconds;
  return scanner.ended();
}

bool parse_date_time(std::string_view cell, DateOrder order, Stamp& stamp) {
  Scanner scanner{cell};
  const auto parts = take_date(scanner);
  if (!parts) return false;
  const auto day = day_of(*parts, order);
  if (!day) return false;
  const auto before = scanner.text.size();
  if (!scanner.take("T") && !scanner.take("t") && !scanner.take("_") && !scanner.take(",")) scanner.skip_blanks();
  scanner.skip_blanks();
  if (scanner.text.size() == before || !take_clock(scanner, stamp)) return false;
  stamp.time += *day * seconds_of_day * nanoseconds;
  return take_zone(scanner, stamp);
}

bool parse_number_stamp(std::string_view cell, std::int64_t unit, Stamp& stamp) {
  Scanner scanner{cell};
  const bool negative = scanner.take("-");
  std::int64_t whole = 0;
  const int digits = scanner.digits(18, whole);
  if (digits == 18 && !scanner.ended() && is_digit(scanner.text.front())) {
    if (whole > 900'000'000'000'000'000) return false;
    whole = 10 * whole + (scanner.text.front() - '0');
    scanner.text.remove_prefix(1);
  }
  const std::int64_t greatest = latest * nanoseconds / unit;
  if (digits == 0 || whole > greatest) return false;
  stamp.time = whole * unit;
  int unit_place = 0;
  for (std::int64_t size = unit; size < nanoseconds; size *= 10) --unit_place;
  stamp.place = unit_place;
  if (scanner.take(".") || scanner.take(",")) {
    int place = 0;
    const std::int64_t fraction = take_fraction(scanner, place);  // of one, in 10^-9
    stamp.time += static_cast<std::int64_t>(
        static_cast<long double>(fraction) * static_cast<long double>(unit) / nanoseconds + 0.5L);
    stamp.place = std::max(unit_place + place, -9);
  }
  if (!scanner.ended() && (scanner.text.front() == 'e' || scanner.text.front() == 'E')) {
    double value = 0.0;  // as a program writes that keeps the time as a floating-point number
    std::string text(cell);
    std::ranges::replace(text, ',', '.');
    const auto result = fast_float::from_chars(text.data(), text.data() + text.size(), value);
    const double time = value * static_cast<double>(unit);
    if (result.ec != std::errc() || result.ptr != text.data() + text.size() || !(std::abs(time) < 4.5e18)) return false;
    const auto e = text.find_first_of("eE");
    const auto point = text.find('.');
    const int behind = point < e ? static_cast<int>(e - point - 1) : 0;
    stamp.place = std::clamp(std::atoi(text.c_str() + e + 1) - behind + unit_place, -9, 9);
    stamp.time = static_cast<std::int64_t>(std::llround(time));
    return true;
  }
  if (negative) stamp.time = -stamp.time;
  return scanner.ended();
}

}  // namespace

StampKind stamp_kind(std::string_view cell) {
  if (cell.size() > 64) return StampKind::none;
  Stamp stamp;
  Scanner time{cell};
  if (take_clock(time, stamp)) return take_zone(time, stamp) ? StampKind::time_of_day : StampKind::none;
  Scanner date{cell};
  if (!take_date(date)) return StampKind::none;
  if (date.ended()) return StampKind::date;
  for (const DateOrder order : {DateOrder::dmy, DateOrder::mdy, DateOrder::ymd})
    if (parse_date_time(cell, order, stamp)) return StampKind::date_time;
  return StampKind::none;
}

bool parse_stamp(std::string_view cell, const StampFormat& format, Stamp& stamp) {
  stamp = {};
  switch (format.kind) {
    case StampKind::date_time:
      return parse_date_time(cell, format.order, stamp);
    case StampKind::number:
      if (!parse_number_stamp(cell, format.unit, stamp) ||
          (format.below != 0 && !(stamp.time >= 0 && stamp.time < format.below)))
        return false;
      stamp.time += format.zero;
      return true;
    case StampKind::time_of_day: {
      Scanner scanner{cell};
      return take_clock(scanner, stamp) && take_zone(scanner, stamp);
    }
    case StampKind::date: {
      Scanner scanner{cell};
      const auto parts = take_date(scanner);
      const auto day = parts && scanner.ended() ? day_of(*parts, format.order) : std::nullopt;
      if (day) stamp.time = *day * seconds_of_day * nanoseconds;
      return day.has_value();
    }
    case StampKind::none:
      break;
  }
  return false;
}

AllowedOrders allowed_orders(std::string_view cell) {
  Scanner scanner{cell};
  const auto parts = take_date(scanner);
  if (!parts) return {};
  if (parts->year_first() || parts->named) return {true, true, true, true};
  AllowedOrders allowed{day_of(*parts, DateOrder::dmy).has_value(), day_of(*parts, DateOrder::mdy).has_value(), false,
                        false};
  allowed.ymd = parts->digits[2] == 2 && parts->separator != '.' && day_of(*parts, DateOrder::ymd).has_value();
  if (parts->separator == '.' && allowed.dmy) allowed.mdy = allowed.ymd = false;  // always written so
  return allowed;
}

}  // namespace tumble::csv
