#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/core/settings.hpp"

namespace tumble::pendulous_accelerometer {

/// Constants that the regressors depend on as well as the coefficients: m L, K and C.
std::vector<Option> stiffness_constants();

/// Masses, lengths, inertias, compliances and torquer; none has a default.
std::vector<Option> physics();

/// m L/(K + C) [rad/(m/s^2)]: angle of the pendulum per specific force along the input axis; 0 where it is not given,
/// and with an integrator.
double tilt_per_specific_force(const Settings& constants);

/// K_I = (m L/K_T) K/(K + C) [A/(m/s^2)], docs/equations (4.15), (4.17); 0 where it is not given.
double current_scale_factor(const Settings& truth);

/// The coefficients of docs/equations (4.18) and (4.19) [SI] by name; empty where no physics is given. The static ones
/// are those of docs/equations (4.17) divided by K_I and turned from the lecture's axes (I, O, P) to (i, p, o),
/// o = -O. Throws Error::bad_input that lists all that is missing or out of bounds.
std::map<std::string, double> coefficients(const Settings& truth);

}  // namespace tumble::pendulous_accelerometer
