#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/methods/imu_ferraris/closed_form.hpp"
#include "tumble/methods/imu_ferraris/turned.hpp"

namespace tumble::imu_ferraris {

inline constexpr std::size_t sections = poses + turns;
inline constexpr std::size_t outputs = 6;  ///< accelerometers x, y, z, gyros x, y, z

/// "x_p", "x_a", ..., "z_a", "x_rot", "y_rot", "z_rot"
const std::array<std::string, sections>& labels();

/// When one part of a section was recorded.
struct Part {
  std::size_t recording = 0;         ///< index in Evidence::recordings
  double begin = 0.0, length = 0.0;  ///< [s, recording's clock], [s]
};

/// Difference of the second half of a part from the first.
struct HalfStep {
  std::size_t part = 0;     ///< index in Section::pieces
  double difference = 0.0;  ///< of the means [u]
  double noise = 0.0;       ///< [1] its variance over the density of the noise
};

/// Differences of the second half of a part from the first: slow noise shows in them.
struct Halves {
  std::vector<HalfStep> steps;
  double squares = 0.0;  ///< of the differences of the means, sum over the parts
  double noise = 0.0;    ///< sum of 4/samples: by so much the density of the noise makes them
  double count = 0.0;
};

/// For how long the samples at the beginning and at the end of a part differ from the others [s].
struct Edges {
  double first = 0.0, last = 0.0;
};

/// All sections of one label together.
struct Section {
  std::size_t parts = 0, samples = 0, missing = 0;
  std::vector<Part> pieces;
  double time = 0.0;                                   ///< [s]
  std::array<double, outputs> mean{};                  ///< over all samples
  std::array<double, outputs> total{};                 ///< integral over time [output s], sum over the parts
  std::array<double, outputs> bridged{};               ///< variance of the total by missing samples [output^2 s^2]
  double longest_bridge = 0.0;                         ///< [s] in which an output has no samples, over all parts
  std::array<std::size_t, outputs> missing_of{};       ///< samples
  std::array<std::array<TurnEnd, 2>, outputs> ends{};  ///< of the last part
  Edges edges;                                         ///< of the part whose edges move for longest
  std::array<double, outputs> density{};  ///< variance of a mean times the number of samples, from means of blocks
  std::array<double, outputs> freedom{};  ///< degrees of freedom of the density
  std::array<Halves, outputs> halves{};
  std::array<double, outputs> least = uniform(std::numeric_limits<double>::infinity());      ///< sample
  std::array<double, outputs> greatest = uniform(-std::numeric_limits<double>::infinity());  ///< sample

  /// Given: value [SI], of every output.
  static constexpr std::array<double, outputs> uniform(double value) {
    std::array<double, outputs> all{};
    all.fill(value);
    return all;
  }
};

/// The recorded sections, in SI of the channels' units.
struct Recorded {
  std::array<Section, sections> section;
  std::array<Unit, outputs> unit;
  std::array<QuantityKind, outputs> kind{};
  std::array<std::string, outputs> channel;  ///< names
  bool gyros = false;                        ///< channels and turns are there
  Findings findings;
};

/// Throws    Error::bad_data with all that is missing: sections by name, channels, samples
Recorded recorded(const Evidence& evidence);

}  // namespace tumble::imu_ferraris
