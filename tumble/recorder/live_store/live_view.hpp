#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "tumble/pyramid/live_samples.hpp"
#include "tumble/recorder/recorder.hpp"

namespace tumble::live_store {

/// Gives what is recorded to those who look at the run while it goes on. An increment is shown as the signal where its
/// rate is declared, else not before the run is sealed. Times are those of arrival.
class LiveView {
 public:
  /// `folder` of the run.
  explicit LiveView(const std::string& folder);
  void add_stream(std::size_t number, const StoreStream& stream);
  void set(const std::string& name, const std::string& value);
  void sample(std::size_t stream, const StoreSample& sample);
  /// A row of the journal at `time` [s].
  void journal(double time, const RunRow& row);

 private:
  std::mutex mutex_;
  LiveSamples samples_;
  std::vector<std::vector<std::size_t>> channels_;  ///< of LiveSamples, by stream and channel; not_shown: none
};

}  // namespace tumble::live_store
