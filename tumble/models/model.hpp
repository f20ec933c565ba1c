#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/math/vector3.hpp"

namespace tumble {

/// What the instrument feels at one instant, in its own axes.
struct Felt {
  Vector3 rate;                       ///< inertial angular rate [rad/s]
  Vector3 angular_acceleration;       ///< [rad/s^2]
  Vector3 specific_force;             ///< [m/s^2]
  double temperature = 293.15;        ///< [K]
  double temperature_gradient = 0.0;  ///< top minus side sensor [K]
  double temperature_rate = 0.0;      ///< [K/s]
  double start_temperature = 293.15;  ///< temperature over the first two minutes after power-on [K]
  double since_power_on = 0.0;        ///< [s]
};

/// One term of an error model: coefficient times regressor, in the unit of the output. The simulator sums the terms,
/// the estimator takes the regressors as its columns, the compensator subtracts them.
struct Term {
  std::string name;
  std::string symbol;
  std::string unit;  ///< of the coefficient, as shown
  std::string description;
  std::function<double(const Felt&)> regressor;
};

/// A catalogue entry of models/: an instrument as a table of terms.
struct Model {
  const char* name;
  const char* summary;
  const char* source;  ///< citation with equation numbers
  QuantityKind output;
  const char* output_unit;  ///< as shown
  /// What the regressors themselves depend on: time constants, reference temperatures.
  std::vector<Option> (*constants)();
  std::vector<Term> (*terms)(const Settings& constants);
};

/// All that [truth] accepts for a model: a coefficient for every term (default 0), its constants, its noise and its
/// turn-on repeatability.
std::vector<Option> truth_options(const Model& model);

/// The noise that the [truth] of a model states.
NoiseModel noise_of(const Settings& truth);

/// The entry of that name, or Error::unsupported with the nearest known name.
const Model& find_model(std::string_view name);

namespace models {
const std::vector<const Model*>& catalogue();
}

}  // namespace tumble
