#pragma once

#include <vector>

#include "tumble/departures/departure.hpp"

/// The departures of each subject, in the order in which they are listed.
namespace tumble::entries {

std::vector<Departure> of_clocks();
std::vector<Departure> of_stamps();
std::vector<Departure> of_positions();
std::vector<Departure> of_motions();
std::vector<Departure> of_rigs();
std::vector<Departure> of_encoders();
std::vector<Departure> of_marks();
std::vector<Departure> of_channels();
std::vector<Departure> of_electronics();
std::vector<Departure> of_converters();
std::vector<Departure> of_samples();
std::vector<Departure> of_drifts();
std::vector<Departure> of_surroundings();

}  // namespace tumble::entries
