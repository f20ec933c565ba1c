#include "tumble/formats/csv/taker.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/core/instant.hpp"
#include "tumble/formats/csv/split_clock.hpp"
#include "tumble/units/error.hpp"

namespace tumble::csv {

bool has_time(const Layout& layout) {
  return layout.stamp.stamped() || std::ranges::any_of(layout.columns, &Column::time);
}

Taker::Taker(const Layout& layout) : layout_(layout) {
  for (const Column& column : layout.columns) {
    if (column.time) {
      numbered_ = true;
      unit_ = column.unit;
      break;
    }
    slot_ += column.wanted;
  }
}

/// [s] since the first stamp. A time of day that falls by half a day has passed midnight; a day of the year that falls
/// by half a year follows the last day of the year before.
double Taker::seconds(std::int64_t stamp) {
  constexpr std::int64_t full_day = 86'400'000'000'000;
  if (!zero_) {
    zero_ = last_ = stamp;
  } else if (layout_.stamp.turn == Turn::day && stamp < last_ - full_day / 2) {
    past_midnight_ = true;
    days_ += full_day;
  } else if (layout_.stamp.turn == Turn::year && stamp < last_ - 180 * full_day) {
    days_ += last_ / full_day * full_day;
  }
  last_ = stamp;
  return static_cast<double>(
      (static_cast<long double>(stamp) + static_cast<long double>(days_) - static_cast<long double>(*zero_)) / 1e9L);
}

/// [ns] The sum of the columns of the clock, those of the date as its midnight.
std::int64_t Taker::stamp_of(const Batch& batch, std::size_t row) {
  const auto column = [&](std::size_t part) { return batch.stamps[part * Batch::capacity + row]; };
  const DateColumns date = layout_.stamp.date;
  std::size_t part = date == DateColumns::none ? 0 : date == DateColumns::year_day ? 2 : 3;
  std::int64_t stamp = 0;
  if (part > 0) {
    const auto midnight = midnight_of(date, column(0), column(1), column(part - 1));
    stamp = midnight.value_or(0);
    if (!midnight && no_date_.empty())
      for (std::size_t i = 0; i < part; ++i) no_date_ += (i > 0 ? "-" : "") + std::to_string(column(i));
  }
  for (; part < layout_.stamp.columns.size(); ++part) stamp += column(part);
  return stamp;
}

void Taker::take_time(const Batch& batch, std::vector<double>* stamps) {
  if (!has_time(layout_)) return;
  times_.resize(batch.rows);
  if (numbered_) {
    const double* const written = batch.column(slot_);
    for (std::size_t i = 0; i < batch.rows; ++i) times_[i] = unit_.to_si(written[i]);
  } else {
    for (std::size_t i = 0; i < batch.rows; ++i) times_[i] = seconds(stamp_of(batch, i));
  }
  const double place = std::pow(10.0, batch.time_exponent) * (numbered_ ? unit_.factor() : 1.0);
  for (const double t : times_) clock_.add(t, place);
  if (stamps != nullptr) stamps->insert(stamps->end(), times_.begin(), times_.end());
}

void Taker::take_values(const Batch& batch, Recording& recording) const {
  std::size_t slot = 0;
  for (Channel& channel : recording.channels) {
    slot += numbered_ && slot == slot_;
    const double* const written = batch.column(slot++);
    const double factor = channel.unit.factor();
    const double offset = channel.unit.offset();
    const std::size_t old = channel.values.size();
    channel.values.resize(old + batch.rows);
    double* const values = channel.values.data() + old;
    for (std::size_t i = 0; i < batch.rows; ++i) values[i] = written[i] * factor + offset;
  }
}

void Taker::take_labels(const Batch& batch) {
  for (const auto& [row, label] : batch.labels)
    labels_.push_back({rows_ + row, row < times_.size() ? times_[row] : 0.0, label});
  rows_ += batch.rows;
}

std::vector<Mark> Taker::marks(const std::optional<Timeline>& clock) const {
  std::vector<Mark> marks;
  for (const Labelled& one : labels_) marks.push_back({one.label, clock ? clock->time(one.row) : one.stamp, 1});
  return marks;
}

std::optional<Timeline> Taker::timeline(const std::string& path, const ReadOptions& options, Findings& findings) const {
  if (!has_time(layout_)) {
    if (options.rate) return Timeline{0.0, *options.rate, nullptr};
    if (layout_.clock) return layout_.clock;
    throw Error{Error::Kind::bad_file, say("'{}' has no time column; add one, time[s], say which column it is (--set "
                                           "time=COLUMN), or give the sampling rate (--set rate=100)",
                                           path)};
  }
  if (!no_date_.empty())
    throw Error{Error::Kind::bad_file,
                say("'{}': the columns of the clock ({}) hold the date {}, which the calendar does not have; correct "
                    "the row, or choose another clock (--set time=COLUMN)",
                    path, Name{layout_.stamp.how}, Name{no_date_})};
  if (past_midnight_) findings.push_back({Finding::Severity::info, "clock_past_midnight", {}, path});
  if (layout_.clock && clock_.allows(*layout_.clock)) return layout_.clock;
  if (layout_.clock) findings.push_back({Finding::Severity::warning, "clock_comment_disagrees", {}, path});
  return clock_.timeline(options.rate);
}

std::string Taker::start() const {
  const StampKind kind = layout_.stamp.kind();
  const bool dated = layout_.stamp.date != DateColumns::none || kind == StampKind::date_time ||
                     kind == StampKind::date ||
                     (kind == StampKind::number && zero_.value_or(0) >= 1'000'000'000'000'000'000);
  return dated && zero_ ? iso_time(*zero_) + (layout_.stamp.zoned ? "Z" : "") : "";
}

}  // namespace tumble::csv
