#pragma once

#include <memory>
#include <string>

#include "tumble/rigs/chain/chain.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble::chain {

/// The encoder of an axis. It shows where the drive stands, turns counted on, positioning and rate errors included; the
/// errors of its own scale and zero it cannot show.
///
/// Given     noise    standard deviation of one reading [rad]
///           quantum  step of the readings [rad]; 0: none
///           rate     [Hz] on which the noise of the readings is counted
Sensor encoder(const std::string& name, const std::shared_ptr<const Chain>& chain, std::size_t axis, double noise,
               double quantum, double rate, const RandomStream& random);

/// The thermometer of the instrument, channel `temperature`: noise [K] and quantum [K] as of an encoder.
Sensor thermometer(const std::shared_ptr<const Chain>& chain, double noise, double quantum, double rate,
                   const RandomStream& random);

/// Adds to readings at first, first + step, ... noise of this standard deviation that depends on the time alone: one
/// number for each interval 1/rate.
/// Given: sd and readings [rad, or unit of the reading]; rate [Hz]; first, step [s].
void add_reading_noise(double sd, double rate, const RandomStream& random, double first, double step,
                       std::span<double> readings);

}  // namespace tumble::chain
