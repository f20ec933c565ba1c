#include "tumble/rigs/rig.hpp"

#include "tumble/core/find.hpp"

namespace tumble {

const Rig& find_rig(std::string_view name) { return find_entry(rig_catalogue(), name, "rig"); }

}  // namespace tumble
