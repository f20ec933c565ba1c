#pragma once

#include <string>

#include "tumble/exchange/calibration.hpp"

/// Corrections that consumers apply by the files that exports write, by their own formulas, which were written down
/// from their code without looking at the exports. Inputs [SI] in axes of the calibration, from outputs [SI].
namespace tumble::testing {

struct Consumed {
  ImuSample sample;
  bool forces = true, rates = true;  ///< what the consumer compensates
};

Consumed kalibr(const std::string& file, const ImuSample& raw);
/// `wrong`: with Kalibr's A in the place of Tg, the trap that its configuration invites.
Consumed openvins(const std::string& file, const ImuSample& raw, bool wrong = false);
Consumed px4(const std::string& file, const ImuSample& raw);
Consumed ardupilot(const std::string& file, const ImuSample& raw);
/// The file of one triad.
Consumed imu_tk(const std::string& file, const ImuSample& raw, bool gyros);
Consumed ros_imu_calib(const std::string& file, const ImuSample& raw);
Consumed imucal(const std::string& file, const ImuSample& raw);
Consumed psins(const std::string& file, const ImuSample& raw);
Consumed matlab(const std::string& file, const ImuSample& raw);

}  // namespace tumble::testing
