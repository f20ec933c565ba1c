#include "tumble/core/find.hpp"
#include "tumble/methods/method.hpp"

namespace tumble {

const Method& find_method(std::string_view name) { return find_entry(methods::catalogue(), name, "method"); }

}  // namespace tumble
