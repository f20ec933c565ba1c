#pragma once

#include <span>
#include <string>

#include "tumble/core/finding.hpp"

namespace tumble {

/// Whether the samples that are missing are those on one side: the values end abruptly there, and on the other side they
/// thin out as noise does. What remains is then no fair sample of the output.
///
/// With s the sd of a sample by the differences of neighbours, noise has one or two values within s/5 of its greatest
/// value. Said where twenty and more distinct ones are there, and less than a fifth of this number at the other end, and
/// a hundredth of the samples is missing.
/// Given: values [u], NaN: missing.
Findings lost_by_value(std::span<const double> values, const std::string& label);

}  // namespace tumble
