#include "tumble/methods/method.hpp"

#include "tumble/core/find.hpp"

namespace tumble {

const Method& find_method(std::string_view name) { return find_entry(method_catalogue(), name, "method"); }

}  // namespace tumble
