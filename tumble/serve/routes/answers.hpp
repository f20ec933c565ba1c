#pragma once

#include "tumble/language/text.hpp"
#include "tumble/serve/guard.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/units/error.hpp"

/// Answers to a request.
namespace tumble::routes {

HttpResponse json_response(const Json& json, unsigned status = 200);
/// {"problems": [...]} with the status that the kind of error has.
HttpResponse problem_response(const Error& error);
HttpResponse problem_response(unsigned status, const Problem& problem);
HttpResponse problem_response(unsigned status, const Problems& problems);

/// A job of the user who asks, in the queue; its identifier as the answer.
HttpResponse started(Context& context, const HttpRequest& request, Job job);

/// Why a password did not let somebody in, for people.
HttpResponse password_refusal(const PasswordCheck& check);

/// Findings of a result or an inspection, their messages in this language.
Json findings_in(Language language, Json findings);

/// An answer whose sentences for people are said in the language that is asked for: members that have their pattern and
/// values beside them (text_said beside text), and by their English text those under problems, message, doing, text,
/// reason and ending_text that have none.
HttpResponse said_response(const HttpRequest& request, Json json, unsigned status = 200);
/// A refusal in the language that is asked for; English where that is unknown.
void say_refusal(const HttpRequest& request, HttpResponse& response);
/// Events whose sentences for people are said in the language that is asked for.
void say_events(const HttpRequest& request, HttpResponse& response);

}  // namespace tumble::routes
