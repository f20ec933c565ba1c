#pragma once

#include <string>

namespace tumble {

/// Problem of a text as the number of a certificate: two numbers must not look alike in print, as "2026-1" does with a
/// non-breaking hyphen, with a space of no width, or with full-width digits. Other scripts are allowed.
/// Returned: the problem, and what is accepted; empty: none.
std::string problem_of_certificate_number(const std::string& number);

}  // namespace tumble
