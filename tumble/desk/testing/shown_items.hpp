#pragma once

#include "tumble/desk/desk_lines/run_json.hpp"

namespace tumble::testing {

/// Whether a desk tells those who watch of this item of a store.
inline bool is_shown(const StoreItem& item) { return desk_lines::is_shown(item); }

}  // namespace tumble::testing
