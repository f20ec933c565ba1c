#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tumble/units/unit.hpp"

/// The error model of an instrument as data: what a result knows, without the program that found it.
namespace tumble {

/// A quantity on which a term may depend. The first fourteen are the numbers of a Felt, in its order.
enum class Input {
  rate_x,
  rate_y,
  rate_z,
  angular_acceleration_x,
  angular_acceleration_y,
  angular_acceleration_z,
  specific_force_x,
  specific_force_y,
  specific_force_z,
  temperature,
  temperature_gradient,
  temperature_rate,
  start_temperature,
  since_power_on,
  angle,    ///< [rad] the instrument's own angle: what an encoder shows
  channel,  ///< any other channel of the recording, by its role
  // short names for tables of terms: w rate, a angular acceleration, f specific force
  w_x = rate_x,
  w_y = rate_y,
  w_z = rate_z,
  a_x = angular_acceleration_x,
  a_y = angular_acceleration_y,
  a_z = angular_acceleration_z,
  f_x = specific_force_x,
  f_y = specific_force_y,
  f_z = specific_force_z
};

inline constexpr std::size_t felt_inputs = 14;
/// "specific_force_x": the role of the channel that measures it.
const char* name(Input input);
/// Absent where no input is called so.
std::optional<Input> input_named(std::string_view name);
/// Unit of SI of an input; "1" of `channel`.
const char* unit_of(Input input);

/// One factor of a regressor: a function of one input x [SI], or of x less the start temperature.
struct TermFactor {
  enum class Form {
    power,      ///< x^n
    magnitude,  ///< |x|
    sine,       ///< sin(n x)
    cosine,     ///< cos(n x)
    decay,      ///< exp(-x/size)
    play        ///< x after a play of half width `size`: p_k = max(x - size, min(x + size, p_(k-1)))
  };
  Input input = Input::rate_x;
  std::string role = {};  ///< of the channel, where the input is `channel`
  Form form = Form::power;
  double origin = 0.0;               ///< [SI of the input] subtracted first
  bool from_start = false;           ///< the start temperature is subtracted too
  int order = 1;                     ///< n
  double size = 1.0;                 ///< [SI of the input]
  std::optional<std::size_t> lag{};  ///< index of the parameter [s] that is the time constant with which x is felt

  bool operator==(const TermFactor&) const = default;
};

/// weight x product of factors [SI].
struct Product {
  double weight = 1.0;
  std::vector<TermFactor> factors = {};

  bool operator==(const Product&) const = default;
};

/// A term: a parameter times a regressor, which is a sum of products.
struct ModelTerm {
  std::string term;                      ///< name in the model's table of terms
  std::optional<std::size_t> parameter;  ///< index in Estimate::parameters; absent: the coefficient is 1
  std::vector<Product> regressor;
  double least = 0.0, greatest = 0.0;  ///< [SI] range of the regressor that the test covered
  bool per_output = false;  ///< it adds to the output itself, not to u: the scale factor does not multiply it
  bool remains = false;     ///< it is never subtracted, and is part of the uncertainty
};

/// How the temperatures of a thermal model come from one or two sensors: see reduce/thermal.
struct ThermalReading {
  double smoothing = 0.0;     ///< [s] window of the local quadratic
  double lag = 0.0;           ///< [s] of the sensors
  double start_window = 0.0;  ///< [s] after power-on whose mean is the start temperature
  double averaging = 0.0;     ///< [s] from power-on on: means over it are compared with `covered`; 0: the samples are
};

/// A weighted sum of inputs and the range of it [SI] that the test covered.
struct Covered {
  std::vector<std::pair<Input, double>> weights;
  double least = 0.0, greatest = 0.0;
  double noise = 0.0;  ///< [SI] how far beyond it a single sample lies that was at its edge
};

/// A straight line and the departures from it as they were measured: in place of the terms, where a user wants these.
struct MeasuredDepartures {
  double slope = 1.0;                  ///< [output/u]
  double offset = 0.0;                 ///< [output]
  std::vector<double> input = {};      ///< [SI of u] rising
  std::vector<double> departure = {};  ///< [output]
};

/// How one output y shows the quantity u that it measures, as a result knows it:
///
///   y = o + K (u + sum_j c_j x_j) + sum_k c_k x_k              (the last sum: terms with per_output)
///   u = y - sum_j c_j x_j(y)                                   (by_output)
struct OutputModel {
  std::string role;                        ///< of the channel: "gyro_x"
  Input shows = Input::rate_x;             ///< u
  Unit unit;                               ///< of u as shown
  std::optional<std::size_t> scale = {};   ///< index of the parameter K; absent: 1
  std::optional<std::size_t> offset = {};  ///< index of the parameter o; absent: 0
  std::optional<std::size_t> spread = {};  ///< index of the sd of u from power-up to power-up
  std::optional<std::size_t> delay = {};   ///< index of the parameter [s]: y at a time shows u that long before
  bool by_output = false;                  ///< regressors take every output in the place of what it shows
  /// A channel in this unit is multiplied by `nominal` [SI of K u per SI of the unit] first. A channel that holds the
  /// integral of it over each sample (increments, counts) is multiplied by its sampling rate too.
  Unit recorded = {};
  double nominal = 1.0;
  double misfit = 0.0;                               ///< [SI of u] sd of what the terms do not follow
  std::optional<ThermalReading> thermal = {};        ///< temperatures are read so; absent: from channels of their names
  std::optional<double> reference_temperature = {};  ///< [K] at which people state temperature terms
  std::vector<Covered> covered = {};                 ///< where the model holds, beside the ranges of the terms
  bool in_region = false;                            ///< `covered` alone says where the model holds
  std::vector<std::string> caveats = {};             ///< codes of findings that belong to every use of the model
  std::vector<ModelTerm> terms = {};
  std::optional<MeasuredDepartures> measured = {};
};

/// The model of the output that plays a role, or null.
const OutputModel* find_model_of(const std::vector<OutputModel>& models, std::string_view role);

}  // namespace tumble
