#include "tumble/formats/csv/read.hpp"

#include <algorithm>

#include "tumble/core/instant.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/csv/lines.hpp"
#include "tumble/formats/csv/rows.hpp"
#include "tumble/formats/csv/taker.hpp"
#include "tumble/math/room.hpp"
#include "tumble/units/error.hpp"

namespace tumble::csv {

namespace {

/// The file as batches of rows, one after the other.
class Batches {
 public:
  Batches(const std::string& path, const ReadOptions& options, const Progress& progress, Look look = Look::at_all)
      : lines_(path, options.encoding),
        progress_(progress),
        text_(lines_.next()),
        layout_(read_layout(path, text_, options, lines_.encoding())),
        rows_(path, layout_, options.missing, look) {}

  const Layout& layout() const { return layout_; }
  std::size_t bytes() const { return lines_.size(); }
  std::size_t bytes_used() const { return lines_.done() - text_.size(); }

  /// False at the end; then every bad cell has been seen and refused.
  bool next(Batch& batch) {
    batch.rows = 0;
    batch.labels.clear();
    while (batch.rows < Batch::capacity) {
      if (text_.empty()) {
        text_ = lines_.next();
        if (text_.empty()) break;
        report(progress_, static_cast<double>(lines_.done()) / static_cast<double>(lines_.size() + 1), "reading");
      }
      rows_.parse(text_, batch);
    }
    if (batch.rows > 0) return true;
    rows_.finish();
    return false;
  }

 private:
  Lines lines_;
  Progress progress_;
  std::string_view text_;
  Layout layout_;
  Rows rows_;
};

/// The channels of the layout, still without samples.
Recording frame(const std::string& path, const Layout& layout) {
  Recording recording = layout.annotations;
  recording.origin.file = path;
  for (const Column& column : layout.columns) {
    if (column.time || !column.wanted) continue;
    const auto kind = layout.kinds.find(column.name);
    recording.channels.push_back(
        {column.name, kind == layout.kinds.end() ? kind_of(column.unit) : kind->second, column.unit, {}, {}});
  }
  if (recording.channels.empty())
    throw Error{Error::Kind::bad_file, say("'{}' has no channel to read except the time", path)};
  return recording;
}

void set_timeline(Recording& recording, const Timeline& timeline) {
  for (Channel& channel : recording.channels) channel.timeline = timeline;
}

void require_rows(const std::string& path, std::size_t rows) {
  if (rows == 0) throw Error{Error::Kind::bad_file, say("'{}' has a header but no samples", path)};
}

/// Room for the whole file, judged by its first rows.
void reserve(Recording& recording, std::vector<double>& stamps, const Batches& batches, std::size_t rows) {
  const double share = static_cast<double>(rows) / static_cast<double>(batches.bytes_used() + 1);
  const auto expected = static_cast<std::size_t>(share * 1.05 * static_cast<double>(batches.bytes())) + rows;
  for (Channel& channel : recording.channels) make_room(channel.values, expected);
  make_room(stamps, expected);
}

}  // namespace

Recording read_table(const std::string& path, const ReadOptions& options, const Progress& progress) {
  Batches batches(path, options, progress);
  Recording recording = frame(path, batches.layout());
  Taker taker(batches.layout());
  std::vector<double> stamps;
  std::size_t rows = 0;
  for (Batch batch; batches.next(batch); rows += batch.rows) {
    if (rows == 0) reserve(recording, stamps, batches, batch.rows);
    taker.take_time(batch, &stamps);
    taker.take_values(batch, recording);
    taker.take_labels(batch);
  }
  require_rows(path, rows);
  const auto clock = taker.timeline(path, options, recording.findings);
  if (const auto start = taker.start(); !start.empty()) recording.meta.emplace(clock_start, start);
  if (auto marks = taker.marks(clock); !marks.empty()) recording.marks = std::move(marks);
  set_timeline(recording,
               clock ? *clock : Timeline{0.0, 0.0, std::make_shared<std::vector<double>>(std::move(stamps))});
  return recording;
}

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress) {
  auto checksum = sha256_in_background(path);
  Recording recording = read_table(path, options, progress);
  recording.origin.checksum = std::move(checksum);
  return recording;
}

namespace {

/// What must be known before the first block is handed out.
struct Times {
  std::optional<Timeline> clock;  ///< empty: the stamps are uneven
  std::vector<Mark> marks;        ///< where labels change
  Findings findings;
  std::string start;  ///< date and time of the first sample
};

/// Found in a first pass over the columns of time and labels alone; the second sees what is wrong behind them.
Times times_of(const std::string& path, const ReadOptions& options) {
  ReadOptions time_only = options;
  time_only.only = {"time"};
  Batches batches(path, time_only, {}, Look::at_wanted);
  Taker taker(batches.layout());
  const bool needed = has_time(batches.layout()) || std::ranges::any_of(batches.layout().columns, &Column::label);
  for (Batch batch; needed && batches.next(batch);) {
    taker.take_time(batch, nullptr);
    taker.take_labels(batch);
  }
  Times times;
  times.clock = taker.timeline(path, options, times.findings);
  times.marks = taker.marks(times.clock);
  times.start = taker.start();
  return times;
}

}  // namespace

void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  const auto [clock, marks, findings, start] = times_of(path, options);
  Batches batches(path, options, progress);
  Recording block = frame(path, batches.layout());
  block.findings.insert(block.findings.end(), findings.begin(), findings.end());
  if (!marks.empty()) block.marks = marks;
  if (!start.empty()) block.meta.emplace(clock_start, start);
  Taker taker(batches.layout());
  std::vector<double> stamps;
  std::size_t sent = 0;
  const auto send = [&] {
    const std::size_t rows = block.channels.front().values.size();
    if (rows == 0) return;
    if (clock)
      set_timeline(block, {clock->time(sent), clock->rate, nullptr});
    else
      set_timeline(block, {0.0, 0.0, std::make_shared<std::vector<double>>(stamps)});
    sink(block);
    block.findings.clear();
    sent += rows;
    stamps.clear();
    for (Channel& channel : block.channels) channel.values.clear();
  };
  for (Batch batch; batches.next(batch);) {
    taker.take_time(batch, clock ? nullptr : &stamps);
    taker.take_values(batch, block);
    if (block.channels.front().values.size() >= samples) send();
  }
  send();
  require_rows(path, sent);
}

}  // namespace tumble::csv
