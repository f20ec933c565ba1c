#pragma once

#include "tumble/math/noise/noise_likelihood/selection.hpp"

namespace tumble::noise_likelihood {

/// The likelihood of these terms with the white noise through a filter. The likelihood of a steep filter has other
/// maxima, where a walk or flicker replaces it: the search begins at the power that was measured, and at that of the
/// filtered noise alone.
TriedTerms with_filter(const BandData& data, bool ramp, const NoiseFilter& filter, NoiseTerms terms);

/// A filter of the white noise of `before`, where it lowers -2 ln L so much that no record of unfiltered noise does it.
/// Returned: whether it does.
bool add_filter(const BandData& data, const SearchRange& range, TriedTerms& before);

/// Puts in the filter that a fit before found, at its best here. Returned: whether there was one.
bool take_filter(const BandData& data, const SearchRange& range, const NoiseFilter& filter, TriedTerms& before);

/// Whether the filter of the second model is worth more than what the first has in its place.
bool filter_needed(const TriedTerms& without, const TriedTerms& with);

/// Fills `other_filters`: a filter of the wrong shape compensates its shape by quantization and by another bandwidth.
void try_other_filters(const BandData& data, const SearchRange& range, TermSelection& selection);

}  // namespace tumble::noise_likelihood
