#pragma once

#include <nanobind/ndarray.h>

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "tumble/core/recording.hpp"

namespace tumble::python {

/// Numbers of NumPy as they lie in memory.
using Samples = nanobind::ndarray<const double, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;

/// A channel before it is one.
struct ChannelParts {
  std::string name, unit;
  Samples values;                 ///< [unit], or SI where `si`
  double start, rate;             ///< [s], [Hz]
  std::optional<Samples> stamps;  ///< [s], in place of start and rate
  bool si;

  ChannelParts(std::string channel, std::string in, Samples numbers, double from, double at,
               std::optional<Samples> stamped, bool is_si)
      : name(std::move(channel)),
        unit(std::move(in)),
        values(std::move(numbers)),
        start(from),
        rate(at),
        stamps(std::move(stamped)),
        si(is_si) {}
};

/// A recording of samples in memory. Its checksum is that of the "file" they were read from, of the "samples", or none.
/// Given: channels; marks as label, begin [s], run, end [s]; the name that messages use. Throws Error::bad_input.
Recording make_recording(const std::vector<ChannelParts>& channels,
                         const std::vector<std::tuple<std::string, double, int, double>>& marks,
                         const std::string& file, const std::string& instrument,
                         const std::map<std::string, std::string>& meta, const std::string& checksum);

/// The samples from `begin` (inclusive) to `end` (exclusive) [s].
Recording between(const Recording& recording, double begin, double end);

}  // namespace tumble::python
