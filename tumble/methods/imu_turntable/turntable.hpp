#pragma once

#include <array>
#include <string>
#include <vector>

#include "tumble/math/matrix3.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/reduce/linear/joint.hpp"

/// Three gyros and three accelerometers on a table, from any schedule.
///
///   w_i' = w_i + b_i + k_i w_i + sum_j m_ij w_j + sum_j g_ij f_j
///   f_i' = f_i + b_i + k_i f_i + sum_j m_ij f_j + K_2i f_i^2 + [a x r_i + w x (w x r_i)]_i
namespace tumble::imu_turntable {

using imu::Kind;

/// The input of the unit in each segment, by the schedule.
struct Look {
  std::vector<std::string> labels;
  std::vector<std::array<std::size_t, 3>> places;  ///< recording, power-up, segment
  std::vector<Vector3> rate, force;                ///< one a segment, mean
  std::vector<bool> even_rate, even_force;         ///< within a tenth of the mean all the time
  std::vector<bool> at_rest;                       ///< all axes held
  double turning = 0.0;                            ///< greatest |w|^2 + |dw/dt| [1/s^2]
  double run_away = 0.0;                           ///< [rad] greatest rate error times time, turning off the vertical
  Vector3 fastest, strongest;                      ///< greatest |w_i| [rad/s] and |f_i| [m/s^2] along each axis
};

/// The unknowns: one problem an output, gyros first.
struct Task {
  std::vector<Kind> kinds;  ///< one or both, in the order of the problems
  std::vector<linear::Problem> problems;
  std::vector<std::string> not_shown;  ///< terms that nothing in the schedule excites usefully
  Look look;
  Findings findings;  ///< of the data
};

/// Throws Error::bad_data where a triad is incomplete or missing altogether.
Task task_of(const Evidence& evidence);
/// Throws Error::bad_input where the plan's model has neither triad.
Task task_of(const Plan& plan);

/// Kinds of terms, in the order in which they are dropped where the schedule cannot distinguish all.
enum class TermKind { second_order, lever, sensitivity, misalignment, scale_factor, bias };

/// One term of an output of the model `imu`.
struct OutputTerm {
  std::string name;  ///< "gyro_x_misalignment_y"
  TermKind kind = TermKind::bias;
  std::size_t axis = 0;  ///< 0, 1 or 2: along which it acts
};

/// All terms of an output of the model `imu`, in its order.
std::vector<OutputTerm> terms_of(Kind kind, std::size_t axis);

/// Findings about the wiring, the units and the order by the means of the segments, and about motion where the table
/// should rest.
Findings faults_of(const Evidence& evidence, const Task& task);

/// The answer with its tables: `observability`, `correction`, `positions`, `rig_errors`, `covered`.
Estimate answer_of(const Task& task, const linear::JointSolution& solution);

/// Value [SI] of a parameter; 0 if the result lacks it, since its term is then not in the model.
double value_of(const Estimate& estimate, const std::string& name);

/// 1 + S [1]: the response of a triad by its scale factor errors and misalignments.
Matrix3 sensitivity_of(const Estimate& estimate, Kind kind);

}  // namespace tumble::imu_turntable
