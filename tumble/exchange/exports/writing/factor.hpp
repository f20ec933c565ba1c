#pragma once

#include "tumble/math/matrix3.hpp"

/// A triad's matrix as a triangle times a rotation.
namespace tumble::writing {

struct Factored {
  Matrix3 triangle;  ///< K = triangle * rotation, with a positive diagonal
  Matrix3 rotation;  ///< its determinant is 1
};

/// With a lower triangle: the first sensor is along the first axis of the new frame.
///
/// Throws    Error::bad_input where the axes are left-handed, so that no rotation does it; `what` names them
/// Accuracy  |K - L Q| below 1e-15 |K|
Factored lower_factor(const Matrix3& response, const char* what);
/// With an upper triangle: the last sensor is along the last axis. Throws, Accuracy: as lower_factor.
Factored upper_factor(const Matrix3& response, const char* what);

/// Angle [rad] of a rotation.
double angle_of(const Matrix3& rotation);

}  // namespace tumble::writing
