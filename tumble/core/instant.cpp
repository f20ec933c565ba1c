#include "tumble/core/instant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>

namespace tumble {

namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;
using Nanoseconds = std::chrono::sys_time<nanoseconds>;

constexpr std::int64_t second = 1'000'000'000;

/// The digits text[at, at + count) as a number below `end`; -1 where they are none.
int digits_at(std::string_view text, std::size_t at, std::size_t count, int end) {
  int value = 0;
  for (const char digit : text.substr(at, count)) {
    if (digit < '0' || digit > '9') return -1;
    value = 10 * value + (digit - '0');
  }
  return value < end ? value : -1;
}

/// [ns] of ".123", or of nothing.
std::optional<std::int64_t> fraction_of(std::string_view text) {
  if (text.empty()) return 0;
  if (text.size() < 2 || text.size() > 10 || text[0] != '.') return std::nullopt;
  const std::string digits = std::string(text.substr(1)) + std::string(10 - text.size(), '0');
  const int value = digits_at(digits, 0, 9, second);
  return value < 0 ? std::nullopt : std::optional<std::int64_t>(value);
}

}  // namespace

std::string iso_day(std::int64_t time) {
  using namespace std::chrono;
  const year_month_day date(floor<days>(Nanoseconds{nanoseconds(time)}));
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()));
}

std::string iso_time(std::int64_t time) {
  using namespace std::chrono;
  const Nanoseconds instant{nanoseconds(time)};
  const hh_mm_ss clock{instant - floor<days>(instant)};
  std::string text = fmt::format("{}T{:02}:{:02}:{:02}", iso_day(time), clock.hours().count(), clock.minutes().count(),
                                 clock.seconds().count());
  auto fraction = clock.subseconds().count();
  if (fraction == 0) return text;
  int digits = 9;
  for (; fraction % 10 == 0; fraction /= 10) --digits;
  return text + fmt::format(".{:0{}}", fraction, digits);
}

std::string iso_second(std::int64_t time) {
  return iso_time(std::chrono::floor<seconds>(Nanoseconds{nanoseconds(time)}).time_since_epoch().count() * second) +
         "Z";
}

std::optional<std::int64_t> parse_iso_time(std::string_view text) {
  using namespace std::chrono;
  constexpr std::string_view form = "0000-00-00T00:00:00";
  if (text.ends_with('Z')) text.remove_suffix(1);
  if (text.size() < form.size()) return std::nullopt;
  for (std::size_t i = 0; i < form.size(); ++i)
    if (form[i] != '0' && text[i] != form[i]) return std::nullopt;
  const int y = digits_at(text, 0, 4, 2262), m = digits_at(text, 5, 2, 13), d = digits_at(text, 8, 2, 32);
  const int hours = digits_at(text, 11, 2, 24), minutes = digits_at(text, 14, 2, 60), s = digits_at(text, 17, 2, 60);
  const auto fraction = fraction_of(text.substr(form.size()));
  const year_month_day date{year(y), month(static_cast<unsigned>(m)), day(static_cast<unsigned>(d))};
  if (y < 1678 || !date.ok() || std::min({hours, minutes, s}) < 0 || !fraction) return std::nullopt;
  const auto of_day = std::chrono::hours(hours) + std::chrono::minutes(minutes) + seconds(s) + nanoseconds(*fraction);
  return (Nanoseconds(sys_days(date)) + of_day).time_since_epoch().count();
}

bool is_set(std::int64_t time) {
  using namespace std::chrono_literals;
  return Nanoseconds(nanoseconds(time)) >= std::chrono::sys_days(2000y / 1 / 1);
}

void Extent::add(const Recording& recording) {
  for (const Channel& channel : recording.channels) {
    if (channel.values.empty()) continue;
    first = std::min(first, channel.time(0));
    last = std::max(last, channel.time(channel.values.size() - 1));
  }
}

TestTimes test_times(const std::map<std::string, std::string>& meta, const Extent& extent) {
  constexpr double longest = 1e9;  // s; no test takes 30 years
  const auto said = meta.find(clock_start);
  const auto start = said == meta.end() ? std::nullopt : parse_iso_time(said->second);
  const double duration = extent.last - extent.first;
  if (!start || !is_set(*start) || !(duration >= 0.0 && duration < longest)) return {};
  const char* const zone = said->second.ends_with('Z') ? "Z" : "";
  const auto to_the_second = [&](std::int64_t time) { return iso_time(time - time % second) + zone; };
  return {to_the_second(*start), to_the_second(*start + std::llround(1e9 * duration))};
}

Table table_of(const std::vector<RecordingTimes>& recordings) {
  Table table{"recordings",
              "Time of the measurement, as the recordings state it (Z: UTC)",
              {{"recording", {}}, {"begun", {}}, {"ended", {}}},
              {}};
  for (const auto& [file, times] : recordings) table.rows.push_back({file, times.begun, times.ended});
  return table;
}

std::vector<RecordingTimes> recording_times(const Estimate& estimate) {
  std::vector<RecordingTimes> recordings;
  const Table* const table = find_table(estimate, "recordings");
  if (!table || table->columns.size() != 3) return recordings;
  for (const auto& row : table->rows) {
    const auto text = [&](std::size_t i) {
      const auto* const cell = i < row.size() ? std::get_if<std::string>(&row[i]) : nullptr;
      return cell ? *cell : std::string();
    };
    recordings.push_back({text(0), {text(1), text(2)}});
  }
  return recordings;
}

}  // namespace tumble
