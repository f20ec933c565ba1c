#pragma once

#include <string>

#include "tumble/serve/routes/routes.hpp"

namespace tumble::routes {

/// A text of the body that goes into a command line or a journal; empty where it is absent. Throws Error::bad_input for
/// one of more than 1000 bytes or with control characters.
std::string plain_text_in(const Json& body, const char* name);

/// Who sends it: the user who has signed in, else the name in the body ("who"); empty: nobody says.
std::string who_of(const Context& context, const HttpRequest& request, const Json& body);

}  // namespace tumble::routes
