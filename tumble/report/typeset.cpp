#include "tumble/report/typeset.hpp"

#include "tumble/report/html/html.hpp"

namespace tumble {

std::string typeset_number(std::string_view text) { return html::number(text); }

std::string typeset_unit(const Unit& unit) { return html::unit(unit); }

std::string typeset_symbol(std::string_view text) { return html::symbol(text); }

}  // namespace tumble
