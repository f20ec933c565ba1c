#pragma once

#include <string>

#include "tumble/archive/deposit.hpp"

namespace tumble::testing {

/// A small result of one parameter, "bias" [deg/h], of a unit of the model "gyro".
struct SampleResult {
  std::string serial = "0173";
  double bias = 1.0;                           ///< [deg/h]
  std::string ended = "2026-03-01T12:00:00Z";  ///< of the recording
  std::string recording_sha256 = std::string(64, 'a');
  double sd = 0.1;       ///< [deg/h], of this result alone
  std::string rig = {};  ///< key of an error that results on one rig share; empty: none
  double rig_sd = 0.5;   ///< [deg/h]
};
std::string sample_json(const SampleResult& sample);
ResultDeposit sample_deposit(const SampleResult& sample);

/// Who does it in tests.
ArchiveAct sample_act(const std::string& why = {});

}  // namespace tumble::testing
