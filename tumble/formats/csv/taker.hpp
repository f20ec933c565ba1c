#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tumble/formats/csv/rows.hpp"
#include "tumble/formats/file/even_clock.hpp"

namespace tumble::csv {

/// Whether the table says the time.
bool has_time(const Layout& layout);

/// Appends batches to the channels, in SI, and to the clock. Stamps that are dates, Unix time or in two columns count
/// from the first of them.
class Taker {
 public:
  explicit Taker(const Layout& layout);

  /// Given  stamps [s]: appended to, where not null
  void take_time(const Batch& batch, std::vector<double>* stamps);
  void take_values(const Batch& batch, Recording& recording) const;
  /// Notes where labels change. To be called once a batch, after take_time().
  void take_labels(const Batch& batch);

  /// A mark where the label changes; none where the file has no column of labels.
  std::vector<Mark> marks(const std::optional<Timeline>& clock) const;
  /// The clock of the file; empty: its stamps must be kept. Throws Error::bad_file when the file has no clock at all.
  std::optional<Timeline> timeline(const std::string& path, const ReadOptions& options, Findings& findings) const;
  /// Date and time of the first sample, where the stamps say it: "2026-11-20T09:00:00.123"; else empty.
  std::string start() const;

 private:
  struct Labelled {
    std::size_t row;
    double stamp;  ///< [s], where the file has time
    std::string label;
  };

  double seconds(std::int64_t stamp);
  std::int64_t stamp_of(const Batch& batch, std::size_t row);

  std::vector<Labelled> labels_;
  std::size_t rows_ = 0;
  const Layout& layout_;
  bool numbered_ = false;  ///< the time is a column of numbers
  std::size_t slot_ = 0;   ///< of that column
  Unit unit_;
  std::vector<double> times_;         ///< [s] of the batch
  std::optional<std::int64_t> zero_;  ///< [ns] the first stamp
  std::int64_t last_ = 0, days_ = 0;  ///< [ns] the stamp before, and full days since the first
  bool past_midnight_ = false;
  std::string no_date_;  ///< the first that the calendar does not have
  file::EvenClock clock_;
};

}  // namespace tumble::csv
