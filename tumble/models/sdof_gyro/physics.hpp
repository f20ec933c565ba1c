#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/core/settings.hpp"

namespace tumble::sdof_gyro {

/// Masses, lengths, inertias, compliances and gains of the gimbal and its loop; none has a default.
std::vector<Option> physics();

/// Rotor momentum H [kg m^2/s]; 0 where it is not given.
double angular_momentum(const Settings& truth);

/// Loop stiffness k = k_u k_i k_m [N m/rad]; 0 where it is not given, and with an integrator.
double loop_stiffness(const Settings& truth);

/// The coefficients of docs/equations (4.5) and (4.11) [SI] by name; empty where no physics is given.
/// Throws Error::bad_input that lists all that is missing or out of bounds.
std::map<std::string, double> coefficients(const Settings& truth);

}  // namespace tumble::sdof_gyro
