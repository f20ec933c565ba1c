#pragma once

#include <vector>

#include "tumble/report/figure.hpp"

namespace tumble::figure {

/// The curves that are drawn of an estimate: its own; where none of them shows residuals, those of its tables: each
/// column "residual", "residual_ROLE" or "ROLE_residual" over the number of the row, with bars of twice the noise where
/// the table has "noise_sd".
std::vector<Curve> curves_to_draw(const Estimate& estimate);

/// Figures that show one quantity of several outputs (axes of the same names and dimensions) together: the first series
/// of each. They come before the others, because one looks for them first.
void add_overviews(std::vector<Figure>& figures);

}  // namespace tumble::figure
