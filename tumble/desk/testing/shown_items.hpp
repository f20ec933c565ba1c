#pragma once

#include "tumble/desk/desk_lines/run_json.hpp"

namespace tumble::testing {

/// Whether those who watch a run see this item of its store.
inline bool is_shown(const StoreItem& item) { return desk_lines::is_shown(item); }

}  // namespace tumble::testing
