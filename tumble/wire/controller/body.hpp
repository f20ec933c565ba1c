#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/wire/controller.hpp"
#include "tumble/wire/controller/framing.hpp"
#include "tumble/wire/controller/template.hpp"

namespace tumble::controller {

/// The bytes of a question, without what is around them. Throws Error::bad_input where a value is missing or does not
/// fit.
std::string request_body(const Controller& controller, const ControllerExchange& exchange, const Content& content);

/// Values of a question, if the bytes are this one.
std::optional<Content> parse_request(const Controller& controller, const ControllerExchange& exchange,
                                     std::string_view body);

/// The bytes of the answer to the question `sent`. Throws Error::bad_input where a value or a word is missing.
std::string reply_body(const Controller& controller, const ControllerExchange& exchange, const std::string& sent,
                       const Content& content);

/// Values of the answer to the question `sent`, if the bytes are one.
std::optional<Content> parse_reply(const Controller& controller, const ControllerExchange& exchange,
                                   std::string_view sent, std::string_view body);

/// Why the bytes refuse the question; absent: they do not.
std::optional<std::string> refusal(const Controller& controller, const ControllerExchange* exchange,
                                   std::string_view body);

/// Bytes that refuse a question, null: one that is unknown; absent: this controller has no such words.
std::optional<std::string> refusal_body(const Controller& controller, const ControllerExchange* exchange,
                                        std::string_view sent, const std::string& text);

/// Whether the controller answers at all.
bool has_reply(const ControllerExchange& exchange);

/// Whether an answer can be made without values.
bool answers_itself(const ControllerExchange& exchange);

/// Sizes of answers to the question `sent`, and of questions.
Sizes reply_sizes(const Controller& controller, const ControllerExchange* exchange);
Sizes request_sizes(const Controller& controller);

/// The reply that the content means: words instead of texts of the device, words of bits, values of the axis that was
/// asked. `problem` of the reply where a text has no meaning.
ControllerReply meaning_of(const Controller& controller, const Content& content, const ControllerRequest& request);

/// The content that means this reply. Throws Error::bad_input for a word that this controller cannot say.
Content content_of(const Controller& controller, const ControllerReply& reply, const ControllerRequest& request);

/// Text of a notice with its state, if the bytes are one.
std::optional<ControllerReply> notice_of(const Controller& controller, std::string_view body);

}  // namespace tumble::controller
