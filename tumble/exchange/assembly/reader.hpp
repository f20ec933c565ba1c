#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/exchange/calibration.hpp"
#include "tumble/units/sentence.hpp"

/// Error models of results as a calibration takes them.
namespace tumble::assembly {

/// One result while it is read. A parameter that is read is no longer `unread`.
class Reader {
 public:
  Reader(const CalibrationInput& input, ImuCalibration& calibration, Problems& problems)
      : input_(input), calibration_(calibration), problems_(problems) {}

  const Estimate& estimate() const { return input_.estimate; }
  const CalibrationInput& input() const { return input_; }
  ImuCalibration& calibration() { return calibration_; }

  /// Value [SI]; nothing where the result lacks it. A value that is not finite is a problem.
  std::optional<double> find(const std::string& name);
  double value_or(const std::string& name, double otherwise) { return find(name).value_or(otherwise); }
  bool has(const std::string& name) const { return find_parameter(input_.estimate, name) != nullptr; }
  /// Text of a setting of the method; empty: not set.
  std::string setting(const std::string& name) const;
  /// Notes that this result states `what` ("gyro_x bias"); a problem where another one did.
  void claim(const std::string& what, std::set<std::string>& claimed);
  void problem(const Sentence& said) { problems_.push_back(say("{}: {}", Name{input_.file}, said)); }
  void note(const std::string& text) { calibration_.notes.push_back(text); }

 private:
  const CalibrationInput& input_;
  ImuCalibration& calibration_;
  Problems& problems_;
};

/// "accelerometer_x", "gyro_z"
std::string role(bool gyro, std::size_t axis);
/// The triad of one kind.
TriadCalibration& triad(ImuCalibration& calibration, bool gyro);
/// The unit of SI of this dimension.
Unit si_unit(const Unit& unit);
/// rad/s or m/s^2.
Unit input_unit(bool gyro);

/// The error models of a result: of a single sensor those of the axis that the user named, else each of its own axis.
/// A term without a place in a calibration is a note.
void read_models(Reader& reader, std::set<std::string>& claimed);

/// White noise, random walk and bias instability by the names of the channels. Returned: whether the result has any.
bool read_noise(Reader& reader, std::set<std::string>& claimed);

}  // namespace tumble::assembly
