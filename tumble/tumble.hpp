#pragma once

/// All that Tumble promises to those who use it as a library: the headers named here keep their meaning between
/// releases of one minor version, and docs/library.md says how to begin. Headers that are not named here may change at
/// any time.

// One function per user intent, and the values that they take and give.
#include "tumble/core/channel.hpp"
#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/finding.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/core/read_options.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/core/schedule.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/optimise.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/unit.hpp"
#include "tumble/version.hpp"

// What is in the catalogues, and what a method of one's own is made of.
#include "tumble/checks/check.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/terms.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"

// Mathematics of test data.
#include "tumble/math/matrix.hpp"
#include "tumble/math/noise/noise_likelihood.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/math/rotation.hpp"
#include "tumble/math/spectrum/power_spectrum.hpp"
#include "tumble/math/stability/allan.hpp"
#include "tumble/math/stability/allan_family.hpp"
#include "tumble/math/stability/allan_family_curve.hpp"
#include "tumble/math/stability/dynamic_stability.hpp"
#include "tumble/math/vector3.hpp"
