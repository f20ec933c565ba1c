#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/recorder/recorder.hpp"

namespace tumble {

/// The plan's method, applied to the samples recorded so far. It may throw as identify() does.
using LiveEstimator = std::function<Estimate(Recording so_far, const Progress& progress)>;
LiveEstimator estimator_of(const Plan& plan);

struct LiveEstimatesOptions {
  bool beside = true;          ///< a thread estimates while the run goes on; else the caller waits in begin()
  std::size_t most_bytes = 0;  ///< of samples that are kept; more of them end the estimating. 0: no limit
};

/// The estimate so far: the samples of a run in memory, exactly those that its recording will have, and from time to
/// time the answer of the method. All functions are called by the thread of the run.
class LiveEstimates {
 public:
  struct Answer {
    std::string slot;                                    ///< empty: there is only one unit
    double time = 0.0;                                   ///< [s] up to which samples were used
    std::shared_ptr<const Estimate> estimate = nullptr;  ///< null: no estimate, and `problem` says why
    Sentence problem = {};
  };

  explicit LiveEstimates(LiveEstimator estimator, LiveEstimatesOptions options = {});
  LiveEstimates(const LiveEstimates&) = delete;
  LiveEstimates& operator=(const LiveEstimates&) = delete;
  ~LiveEstimates();  ///< an estimate under way is given up

  /// `index`: of the link or stream in the store.
  void link(std::size_t index, const StoreLink& link);
  void stream(std::size_t index, const StoreStream& stream);
  void sample(std::size_t stream, const StoreSample& sample);
  /// A row of the journal at `time` [s].
  void journal(double time, const RunRow& row);
  /// Loads the samples that a run which is carried on has recorded before. Throws Error::bad_file.
  void load(const std::string& run);

  /// Estimates from everything up to now [s]. False: the thread has not finished the last one or rests, so that it
  /// takes a fifth of a processor at most; or there are no samples, or too many.
  bool begin(double now);
  /// The answers since the last call.
  std::vector<Answer> finished();

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

}  // namespace tumble
