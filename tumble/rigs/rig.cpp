#include "tumble/core/find.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble {

const Rig& find_rig(std::string_view name) { return find_entry(rigs::catalogue(), name, "rig"); }

}  // namespace tumble
