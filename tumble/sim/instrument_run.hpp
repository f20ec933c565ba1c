#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "tumble/math/random.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/sim/source.hpp"

namespace tumble {

/// The instruments of one power-up, portion after portion. A copy goes on from where the original is, so that a portion
/// can be made again where it turns out that the rig moved in another way.
class InstrumentRun {
 public:
  /// Switched on: the turn-on biases are drawn, noise and electronics are at their beginning. The plan must live as
  /// long. Of `run` the number, the begin and the number of samples count: bias instability is simulated as slow as
  /// four records of that length.
  InstrumentRun(const Plan& plan, const PlannedRun& run, const RandomStream& random);
  InstrumentRun(const InstrumentRun& other);
  InstrumentRun(InstrumentRun&&) noexcept;
  InstrumentRun& operator=(const InstrumentRun& other);
  InstrumentRun& operator=(InstrumentRun&&) noexcept;
  ~InstrumentRun();

  /// Without values.
  const std::vector<Channel>& channels() const;
  /// Samples that are made at once: portions begin at whole multiples of it.
  std::size_t portion() const;

  /// Sets what the instrument feels from now on.
  ///
  /// Given     reference  of the power-up
  ///           segments   of the power-up: what is felt may change its course from one to the next
  ///           samples    of the power-up [1]
  void follow(const Reference& reference, const Schedule& segments, std::size_t samples);

  /// The samples of one portion, which begins at sample `first`; in order.
  void make(std::size_t first, const Samples& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tumble
