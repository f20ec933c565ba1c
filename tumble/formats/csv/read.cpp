#include "tumble/formats/csv/read.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/csv/lines.hpp"
#include "tumble/formats/csv/rows.hpp"
#include "tumble/formats/file/even_clock.hpp"
#include "tumble/math/room.hpp"
#include "tumble/units/error.hpp"

namespace tumble::csv {

namespace {

/// The file as batches of rows, one after the other.
class Batches {
 public:
  Batches(const std::string& path, const ReadOptions& options, const Progress& progress, Look look = Look::at_all)
      : lines_(path),
        progress_(progress),
        text_(lines_.next()),
        layout_(read_layout(path, text_, options)),
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

std::size_t time_slot(const Layout& layout) {
  std::size_t slot = 0;
  for (const Column& column : layout.columns) {
    if (column.time) return slot;
    slot += column.wanted;
  }
  return slot;
}

bool has_time(const Layout& layout) {
  for (const Column& column : layout.columns)
    if (column.time) return true;
  return false;
}

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
    throw Error{Error::Kind::bad_file, "'" + path + "' has no channel to read except the time"};
  if (layout.mark == ',') recording.findings.push_back({Finding::Severity::info, "decimal_comma", {}, path});
  return recording;
}

/// Appends a batch to the channels, in SI, and to the clock.
class Taker {
 public:
  Taker(const Layout& layout) : layout_(layout), timed_(has_time(layout)), slot_(time_slot(layout)) {
    for (const Column& column : layout.columns)
      if (column.time) unit_ = column.unit;
  }

  void take_time(const Batch& batch, std::vector<double>* stamps) {
    if (!timed_) return;
    const double place = std::pow(10.0, batch.time_exponent) * unit_.factor();
    const double* const written = batch.column(slot_);
    for (std::size_t i = 0; i < batch.rows; ++i) {
      const double t = unit_.to_si(written[i]);
      clock_.add(t, place);
      if (stamps != nullptr) stamps->push_back(t);
    }
  }

  void take_values(const Batch& batch, Recording& recording) const {
    std::size_t slot = 0;
    for (Channel& channel : recording.channels) {
      slot += timed_ && slot == slot_;
      const double* const written = batch.column(slot++);
      const double factor = channel.unit.factor();
      const double offset = channel.unit.offset();
      const std::size_t old = channel.values.size();
      channel.values.resize(old + batch.rows);
      double* const values = channel.values.data() + old;
      for (std::size_t i = 0; i < batch.rows; ++i) values[i] = written[i] * factor + offset;
    }
  }

  /// Notes where labels change. To be called once a batch, whatever else is taken.
  void take_labels(const Batch& batch) {
    for (const auto& [row, label] : batch.labels)
      labels_.push_back({rows_ + row, timed_ ? unit_.to_si(batch.column(slot_)[row]) : 0.0, label});
    rows_ += batch.rows;
  }

  /// A mark where the label changes; none where the file has no column of labels.
  std::vector<Mark> marks(const std::optional<Timeline>& clock) const {
    std::vector<Mark> marks;
    for (const Labelled& one : labels_) marks.push_back({one.label, clock ? clock->time(one.row) : one.stamp, 1});
    return marks;
  }

  /// The clock of the file; empty: its stamps must be kept. Throws Error::bad_file when there is none at all.
  std::optional<Timeline> timeline(const std::string& path, const ReadOptions& options, Findings& findings) const {
    if (!timed_) {
      if (options.rate) return Timeline{0.0, *options.rate, nullptr};
      if (layout_.clock) return layout_.clock;
      throw Error{Error::Kind::bad_file,
                  "'" + path + "' has no time column; add one, time[s], or give the sampling rate (--set rate=100)"};
    }
    if (layout_.clock && clock_.allows(*layout_.clock)) return layout_.clock;
    if (layout_.clock) findings.push_back({Finding::Severity::warning, "clock_comment_disagrees", {}, path});
    return clock_.timeline();
  }

 private:
  struct Labelled {
    std::size_t row;
    double stamp;  ///< [s], where the file has time
    std::string label;
  };

  std::vector<Labelled> labels_;
  std::size_t rows_ = 0;
  const Layout& layout_;
  bool timed_;
  std::size_t slot_;
  Unit unit_;
  file::EvenClock clock_;
};

void set_timeline(Recording& recording, const Timeline& timeline) {
  for (Channel& channel : recording.channels) channel.timeline = timeline;
}

void require_rows(const std::string& path, std::size_t rows) {
  if (rows == 0) throw Error{Error::Kind::bad_file, "'" + path + "' has a header but no samples"};
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
  return times;
}

}  // namespace

void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  const auto [clock, marks, findings] = times_of(path, options);
  Batches batches(path, options, progress);
  Recording block = frame(path, batches.layout());
  block.findings.insert(block.findings.end(), findings.begin(), findings.end());
  if (!marks.empty()) block.marks = marks;
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
