#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/language/text.hpp"
#include "tumble/serve/routes/routes.hpp"

/// Parameters, body and sender of a request.
namespace tumble::routes {

/// Who asks; empty: whoever has the link, and who shows nothing.
std::string user_of(const Context& context, const HttpRequest& request);

/// The run that the body of an order says must end, by its safe list; nothing: it says something else.
std::optional<std::string> run_to_be_stopped(const HttpRequest& request);

/// The body as an object of JSON. Throws Error::bad_input.
Json body_of(const HttpRequest& request);
/// A text of the body; empty where it is absent. Throws Error::bad_input where it is no text.
std::string text_in(const Json& body, const char* name);

/// A parameter of the query [as written]. Throws Error::bad_input where it is missing, or is no number.
std::string required(const HttpRequest& request, std::string_view name);
/// One that may be absent; empty then.
std::string optional(const HttpRequest& request, std::string_view name);
/// One that is a number [as written].
double required_number(const HttpRequest& request, std::string_view name);
/// Number of the last event that was seen: the header Last-Event-ID, or the parameter after; 0: no event has had it.
std::optional<std::uint64_t> last_event_of(const HttpRequest& request);
std::vector<std::string> all_of(const HttpRequest& request, std::string_view name);

/// The parameter language: English where it is absent. Throws Error::unsupported for another language.
Language language_asked(const HttpRequest& request);

}  // namespace tumble::routes
