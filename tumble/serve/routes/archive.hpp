#pragma once

#include <string>

#include "tumble/archive/archive.hpp"
#include "tumble/serve/routes/routes.hpp"

/// Helpers that the routes of the archive have in common.
namespace tumble::routes {

/// The archive of this workbench. Throws Error::bad_input where it has none.
Archive archive_of(const Context& context);

/// Now, UTC: "2026-11-24T09:00:00Z".
std::string utc_now(const Context& context);

/// Who asks: the user, or with the link the person whose login started the server.
std::string person_of(const Context& context, const HttpRequest& request);

/// An answer that is a page of somebody's data: it runs in a sandbox, and shows itself in frames of our own pages only.
HttpResponse sandboxed(const std::string& type, std::string body);

}  // namespace tumble::routes
