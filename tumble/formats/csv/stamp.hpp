#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tumble::csv {

/// Kind of the cells of a column that is a clock.
enum class StampKind {
  none,
  date_time,    ///< 2026-11-20T09:00:00.123, 20.11.2026 09:00:00,123
  date,         ///< 20.11.2026
  time_of_day,  ///< 09:00:00.123
  number        ///< a decimal number of `unit`
};

/// Order of the numbers of a date.
enum class DateOrder { open, ymd, dmy, mdy };

struct StampFormat {
  StampKind kind = StampKind::none;
  DateOrder order = DateOrder::open;  ///< for dates that do not begin with the year
  std::int64_t unit = 1;              ///< [ns] of one, for numbers
  std::int64_t below = 0;             ///< [ns] numbers are from zero to less than this; 0: any
  std::int64_t zero = 0;              ///< [ns] Unix time of the number zero
};

struct Stamp {
  std::int64_t time = 0;  ///< [ns] since 1970-01-01, midnight, or zero of the number
  int place = 0;          ///< exponent of ten of the last digit, in seconds
  bool zoned = false;     ///< the time zone is said
};

/// Kind of the stamp in a cell, as far as one cell shows it: dates and times with separators. A number gives `none`.
StampKind stamp_kind(std::string_view cell);

/// The stamp in a cell; false where it is not one of this format.
bool parse_stamp(std::string_view cell, const StampFormat& format, Stamp& stamp);

/// The orders that a date allows; a date that begins with the year or names the month allows every order.
struct AllowedOrders {
  bool dmy = true, mdy = true, ymd = true;
  bool plain = false;  ///< the date itself says its order
};
AllowedOrders allowed_orders(std::string_view cell);

}  // namespace tumble::csv
