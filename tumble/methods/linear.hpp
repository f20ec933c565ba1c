#pragma once

/// The engine of linear identification for those outside of methods: tasks predict with it what has no method.
#include "tumble/methods/linear/linear.hpp"
