#pragma once

#include <vector>

#include "tumble/math/vector3.hpp"
#include "tumble/reduce/compensation/work.hpp"

/// One sample of all outputs.
namespace tumble::compensation {

/// "specific_force_x", or the role of another channel; "... after a lag of 3 s".
std::string name_of(const Slot& slot);

/// Sum of the terms of an output [SI of u].
double errors_at(const Work& work, const Values& values);

/// Puts u into each output and its slot, one output after the other, each with what the others show by now, until
/// nothing changes. NaN where there is no root of which the model is sure.
void solve_together(Works& works, Values& values);

/// Variance [SI^2] of the u of each output: by all parameters, those of the outputs that it depends on with them (their
/// own dependence on each other is of second order), by what stays in, and by the `sd` [rad/s^2] of the angular
/// acceleration.
std::vector<double> variances_of(const Works& works, Values& values, const Vector3& sd);

/// The solution in its place, with the sizes of the terms, the derivatives of u, and whether the calibration covered
/// it: `compared` are the values that this is asked of. `informed`: all inputs have values.
void take_solution(Work& work, const Values& values, const Values& compared, std::size_t i, bool informed,
                   Channel& channel);

/// The ranges that can be checked: those whose inputs are known.
void set_cover(const std::vector<Slot>& slots, const Inputs& known, const Works& works, Work& work);

}  // namespace tumble::compensation
