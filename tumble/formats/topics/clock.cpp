#include "tumble/formats/topics/clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace tumble::topics {
namespace {

/// Without overflow: damaged stamps may lie anywhere.
double apart(std::int64_t later, std::int64_t earlier) {
  return 1e-9 * (static_cast<double>(later) - static_cast<double>(earlier));
}

}  // namespace

void ClockSummary::add(std::int64_t stamp, std::int64_t time) {
  if (count++ == 0) {
    first_stamp = stamp;
    first_received = time;
  } else {
    backward += time < last_received;
    stamped_backward += stamp < last_stamp;
  }
  if (count == 2) second_stamp = stamp;
  zeros += stamp == 0;
  last_stamp = stamp;
  last_received = time;
}

bool ClockSummary::begins_at_zero() const {
  constexpr double pause = 10.0, intervals = 100.0;  // s; as many intervals: more is no step of one clock
  if (count < 2 || zeros != 1 || first_stamp != 0) return false;
  const double rest = count > 2 ? apart(last_stamp, second_stamp) / static_cast<double>(count - 2) : 0.0;
  return apart(second_stamp, 0) <= std::max(pause, intervals * rest);
}

ClockChoice choose_clock(const ClockSummary& clock, const std::string& topic, Findings& findings) {
  constexpr double late = 1.0;                 // s: more is no delay on the way to the recorder
  constexpr double slack = 0.5, alike = 0.01;  // s, share of the length
  constexpr double another_speed = 2.0;        // a recording that was played fast or slowly, or converted
  const double header = apart(clock.last_stamp, clock.first_stamp);
  const double recorder = apart(clock.last_received, clock.first_received);
  if (clock.count == 0) return {};
  const auto say = [&](Finding::Severity severity, const char* code, std::vector<FindingValue> values) {
    findings.push_back({severity, code, std::move(values), topic});
  };
  if (clock.zeros > 0 && !clock.begins_at_zero()) {
    say(Finding::Severity::warning, "header_stamps_zero", {{"zeros", clock.zeros}, {"messages", clock.count}});
    return {.header = false};
  }
  if (clock.count > 1 && header <= 0.0 && recorder > 0.0) {
    say(Finding::Severity::warning, "header_stamps_stand_still", {});
    return {.header = false};
  }
  if (std::abs(header - recorder) > std::max(slack, alike * std::max(header, recorder))) {
    const bool use_header = !(recorder * another_speed > header && recorder < another_speed * header);
    say(Finding::Severity::warning, use_header ? "recorder_at_another_speed" : "header_stamps_at_another_rate",
        {{"header", header, "s"}, {"recorder", recorder, "s"}});
    if (!use_header) return {.header = false};
  }
  const double offset = apart(clock.first_received, clock.first_stamp);
  if (std::abs(offset) <= late) return {};
  say(Finding::Severity::info, "header_stamps_of_another_clock", {{"offset", offset, "s"}});
  return {.header = true, .offset = difference(clock.first_received, clock.first_stamp)};
}

std::string epoch_text(std::int64_t time) {
  using namespace std::chrono;
  constexpr std::int64_t second = 1'000'000'000;
  if (time < 0) return fmt::format("{:.9f} s", 1e-9 * static_cast<double>(time));
  const std::int64_t whole = time / second, rest = time % second;
  const sys_seconds instant{std::chrono::seconds{whole}};
  const auto day = floor<days>(instant);
  const year_month_day date{day};
  const hh_mm_ss clock{instant - day};
  return fmt::format("{}.{:09} s ({:04}-{:02}-{:02} {:02}:{:02}:{:02}.{:09} UTC)", whole, rest,
                     static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()), clock.hours().count(), clock.minutes().count(),
                     clock.seconds().count(), rest);
}

}  // namespace tumble::topics
